//! Another program whose output is read with a time limit, and which is ended and waited for whatever happens.

use super::stream::{Started, Stream, is_pending, start};
use std::io::{self, BufRead, BufReader, Read};
use std::process::{Child, Command};
use std::time::{Duration, Instant};

/// Bytes of a line of text: headers and times take less than 100.
const MAX_LINE: usize = 4096;
/// Bytes of stderr that are kept, and characters of them that are shown.
const KEPT: usize = 4096;
const SHOWN: usize = 300;
/// Bytes of stderr that are read at a time: a program that writes there without end must not keep its reader busy.
const ERRORS_AT_A_TIME: usize = 1 << 18;

/// Why the output of a program ends without what was asked for.
#[derive(Debug)]
pub(super) enum Stop {
    /// Nothing whole within the time limit.
    Silent(Duration),
    /// The program ended, or closed its output.
    Ended,
    /// A line without an end.
    LongLine,
    /// The system said so.
    System(io::Error),
}

impl std::fmt::Display for Stop {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Silent(limit) => write!(f, "nothing whole came from it for {:.1} s, the limit", limit.as_secs_f64()),
            Self::Ended => f.write_str("it ended"),
            Self::LongLine => write!(f, "it wrote a line of more than {MAX_LINE} bytes"),
            Self::System(error) => write!(f, "its output cannot be read: {error}"),
        }
    }
}

/// A program that runs.
pub(super) struct Program {
    child: Child,
    output: BufReader<Stream>,
    errors: Stream,
    /// The end of what it wrote to stderr.
    said: Vec<u8>,
    limit: Duration,
    deadline: Instant,
}

impl Program {
    /// Starts a program that must give something whole within `limit`, again and again.
    pub(super) fn start(command: Command, limit: Duration) -> io::Result<Self> {
        let Started { child, output, errors } = start(command)?;
        let (output, said, deadline) = (BufReader::with_capacity(1 << 16, output), Vec::new(), Instant::now() + limit);
        Ok(Self { child, output, errors, said, limit, deadline })
    }

    /// Begins the time limit anew, for the next thing that is asked for.
    pub(super) fn restart_clock(&mut self) {
        self.deadline = Instant::now() + self.limit;
    }

    /// The next line without its end; none when the output ends.
    pub(super) fn read_line(&mut self) -> Result<Option<String>, Stop> {
        let mut line = Vec::new();
        loop {
            let piece = self.available_output()?;
            let end = piece.iter().position(|&byte| byte == b'\n');
            let taken = end.map_or(piece.len(), |at| at + 1);
            line.extend_from_slice(&piece[..end.unwrap_or(taken)]);
            self.output.consume(taken);
            match taken {
                _ if line.len() > MAX_LINE => return Err(Stop::LongLine),
                0 if line.is_empty() => return Ok(None),
                _ if end.is_some() || taken == 0 => {
                    return Ok(Some(String::from_utf8_lossy(&line).trim_end().to_owned()));
                }
                _ => {}
            }
        }
    }

    /// Fills a buffer.
    pub(super) fn fill_buffer(&mut self, mut buffer: &mut [u8]) -> Result<(), Stop> {
        while !buffer.is_empty() {
            self.check_clock()?;
            match self.output.read(buffer) {
                Ok(0) => return Err(Stop::Ended),
                Ok(read) => buffer = &mut buffer[read..],
                Err(error) => self.wait_on(error)?,
            }
        }
        Ok(())
    }

    /// What of the output is there, empty at its end.
    fn available_output(&mut self) -> Result<&[u8], Stop> {
        loop {
            self.check_clock()?;
            match self.output.fill_buf() {
                Ok(_) => break,
                Err(error) => self.wait_on(error)?,
            }
        }
        Ok(self.output.buffer())
    }

    fn check_clock(&self) -> Result<(), Stop> {
        if Instant::now() < self.deadline { Ok(()) } else { Err(Stop::Silent(self.limit)) }
    }

    /// Nothing was there: reads stderr, which would block the program when it is full.
    fn wait_on(&mut self, error: io::Error) -> Result<(), Stop> {
        if !is_pending(&error) {
            return Err(Stop::System(error));
        }
        self.read_errors();
        Ok(())
    }

    fn read_errors(&mut self) {
        let mut buffer = [0; KEPT];
        for _ in 0..ERRORS_AT_A_TIME / KEPT {
            let Ok(read @ 1..) = self.errors.read(&mut buffer) else { break };
            self.said.extend_from_slice(&buffer[..read]);
            self.said.drain(..self.said.len().saturating_sub(KEPT));
        }
    }

    /// Ends the program, and gives the end of what it wrote to stderr in one line.
    pub(super) fn end_program(&mut self) -> String {
        self.read_errors();
        self.stop();
        let text = String::from_utf8_lossy(&self.said);
        let lines = text.split(|c: char| c.is_control()).map(str::trim).filter(|line| !line.is_empty());
        let line: Vec<char> = lines.collect::<Vec<_>>().join("; ").chars().collect();
        line[line.len().saturating_sub(SHOWN)..].iter().collect()
    }

    fn stop(&mut self) {
        // both fail when it has ended already
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

impl Drop for Program {
    /// No process is left behind, neither running nor to be waited for.
    fn drop(&mut self) {
        self.stop();
    }
}
