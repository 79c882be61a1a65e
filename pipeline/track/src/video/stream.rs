//! Output of another program that is read without waiting for long.
//!
//! A program may write nothing, or leave a program of its own behind that keeps its output open. On Unix both outputs are therefore
//! sockets, whose reading returns after a given time, and no thread is needed. Elsewhere a thread reads each output.

use std::io;
use std::process::{Child, Command};
use std::time::Duration;

/// How long the reading of the output waits before it returns, so that what the program writes to stderr is read as well.
const POLL: Duration = Duration::from_millis(10);

/// A program that runs, its output and its stderr. Reading gives [`io::ErrorKind::WouldBlock`] where nothing was written yet.
pub(super) struct Started {
    pub(super) child: Child,
    pub(super) output: Stream,
    pub(super) errors: Stream,
}

/// Whether reading may be tried again.
pub(super) fn is_pending(error: &io::Error) -> bool {
    use io::ErrorKind::{Interrupted, TimedOut, WouldBlock};
    matches!(error.kind(), WouldBlock | TimedOut | Interrupted)
}

#[cfg(unix)]
pub(super) use unix::{Stream, start};

#[cfg(unix)]
mod unix {
    use super::{Command, POLL, Started, io};
    use std::os::fd::OwnedFd;
    use std::os::unix::net::UnixStream;

    pub(in crate::video) type Stream = UnixStream;

    /// Starts a program. The command is dropped with the program's ends of the sockets, so that the output ends when the program does.
    pub(in crate::video) fn start(mut command: Command) -> io::Result<Started> {
        let (output, its_output) = UnixStream::pair()?;
        let (errors, its_errors) = UnixStream::pair()?;
        output.set_read_timeout(Some(POLL))?;
        errors.set_nonblocking(true)?;
        command.stdout(OwnedFd::from(its_output)).stderr(OwnedFd::from(its_errors));
        let child = command.spawn()?;
        Ok(Started { child, output, errors })
    }
}

#[cfg(not(unix))]
pub(super) use elsewhere::{Stream, start};

#[cfg(not(unix))]
mod elsewhere {
    use super::{Command, Duration, POLL, Started, io};
    use std::io::{Cursor, Read};
    use std::process::Stdio;
    use std::sync::mpsc::{Receiver, RecvTimeoutError, sync_channel};

    /// What a thread has read of an output.
    pub(in crate::video) struct Stream {
        pieces: Receiver<Vec<u8>>,
        piece: Cursor<Vec<u8>>,
        wait: Duration,
    }

    /// Starts a program.
    pub(in crate::video) fn start(mut command: Command) -> io::Result<Started> {
        let mut child = command.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn()?;
        let output = Stream::of(child.stdout.take(), POLL);
        let errors = Stream::of(child.stderr.take(), Duration::from_millis(1));
        Ok(Started { child, output, errors })
    }

    impl Stream {
        /// The thread ends with the output, or when the stream is dropped.
        fn reading_from(mut output: Option<impl Read + Send + 'static>, wait: Duration) -> Self {
            let (sender, pieces) = sync_channel(4);
            std::thread::spawn(move || {
                let mut buffer = vec![0; 1 << 16];
                while let Some(Ok(read @ 1..)) = output.as_mut().map(|o| o.read(&mut buffer)) {
                    if sender.send(buffer[..read].to_vec()).is_err() {
                        break;
                    }
                }
            });
            Self { pieces, piece: Cursor::default(), wait }
        }
    }

    impl Read for Stream {
        fn read(&mut self, into: &mut [u8]) -> io::Result<usize> {
            if self.piece.position() == self.piece.get_ref().len() as u64 {
                match self.pieces.recv_timeout(self.wait) {
                    Ok(piece) => self.piece = Cursor::new(piece),
                    Err(RecvTimeoutError::Timeout) => return Err(io::ErrorKind::WouldBlock.into()),
                    Err(RecvTimeoutError::Disconnected) => return Ok(0),
                }
            }
            self.piece.read(into)
        }
    }
}
