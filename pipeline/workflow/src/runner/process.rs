//! Processes: which one holds a lock, and whether it still runs.
//!
//! On the machine that asks, a process is found by its number and its start, so that a number that was given again deceives nobody.
//! Machines are distinguished by name, boot and process namespace: containers of one machine may share a name and see other processes.

use std::fs;
use std::process::Command;
use std::time::{SystemTime, UNIX_EPOCH};

use serde::{Deserialize, Serialize};

/// A process that holds locks, as it is written into each of them.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Process {
    /// Different for each process and each of its runs: hashes of its machine, then its number, then hashes of its start and of the moment.
    pub token: String,
    /// The machine's name.
    pub host: String,
    /// The machine's boot and process namespace.
    pub machine: String,
    /// The identity of its system, which outlives a boot; empty where it has none.
    #[serde(default)]
    pub system: String,
    /// The number of the process.
    pub pid: u32,
    /// Its start, as the system counts it.
    pub started: String,
    /// When it began to take locks, s since 1970.
    pub since: u64,
}

impl Process {
    /// This process.
    pub fn this() -> Self {
        let (pid, now) = (std::process::id(), SystemTime::now().duration_since(UNIX_EPOCH).unwrap_or_default());
        let (host, machine) = (host_name(), boot_and_namespace());
        let started = start_time(pid).unwrap_or_default();
        let moment = short_hash(&format!("{} {:?}", now.as_nanos(), std::thread::current().id()));
        let token = format!("{}-{pid}-{}-{moment}", machine_hash(&host, &machine), short_hash(&started));
        Self { token, host, machine, system: machine_identity(), pid, started, since: now.as_secs() }
    }

    /// Whoever left a lock that is not understood.
    pub(super) fn unknown() -> Self {
        let (token, host) = ("unknown".to_owned(), "unknown".to_owned());
        let (machine, system, started) = (String::new(), String::new(), String::new());
        Self { token, host, machine, system, pid: 0, started, since: 0 }
    }

    /// Whether nothing is known of it.
    pub(super) fn is_unknown(&self) -> bool {
        self.machine.is_empty() && self.pid == 0
    }

    /// Whether it ran on the machine of `other` before that was started the last time, which it cannot have survived. Name and identity must
    /// agree: machines that are copies of each other may share one of them.
    pub(super) fn is_of_an_earlier_boot(&self, other: &Self) -> bool {
        let boot = |process: &Self| process.machine.split(' ').next().unwrap_or_default().to_owned();
        let same_system = !self.system.is_empty() && (&self.host, &self.system) == (&other.host, &other.system);
        same_system && boot(self) != boot(other)
    }

    /// Whether it ran on the machine of `other`, where it can be asked for. A system that does not report the start of a process counts as
    /// another machine.
    pub(super) fn is_beside(&self, other: &Self) -> bool {
        !self.started.is_empty() && (&self.host, &self.machine) == (&other.host, &other.machine)
    }

    /// Whether `token` is of a process of this machine that has ended. A process that was killed before it had written its file is known
    /// by nothing else.
    pub(super) fn has_ended_here(&self, token: &str) -> bool {
        let parts: Vec<&str> = token.split('-').collect();
        let [machine, pid, start, _] = parts[..] else { return false };
        let same_machine = !self.started.is_empty() && machine == machine_hash(&self.host, &self.machine);
        let runs = |pid: u32| start_time(pid).is_some_and(|started| short_hash(&started) == start);
        same_machine && pid.parse().is_ok_and(|pid| !runs(pid))
    }

    /// Whether it runs, asked on its own machine.
    pub fn runs(&self) -> bool {
        start_time(self.pid).is_some_and(|started| started == self.started)
    }
}

impl std::fmt::Display for Process {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self.is_unknown() {
            true => write!(f, "an unknown process"),
            false => write!(f, "process {} on {}", self.pid, self.host),
        }
    }
}

/// A machine in a token.
fn machine_hash(host: &str, machine: &str) -> String {
    short_hash(&format!("{host} {machine}"))
}

fn short_hash(text: &str) -> String {
    blake3::hash(text.as_bytes()).to_hex()[..8].to_owned()
}

/// The start of a process that runs; none of one that has ended.
fn start_time(pid: u32) -> Option<String> {
    if cfg!(target_os = "linux") {
        return of_stat(&fs::read_to_string(format!("/proc/{pid}/stat")).ok()?);
    }
    program_output("ps", &["-o", "lstart=", "-p", &pid.to_string()])
}

/// The start in a line of `/proc/PID/stat`; none of a process that has ended and waits for its parent.
fn of_stat(line: &str) -> Option<String> {
    // The second field is the program's name in parentheses and may hold both spaces and parentheses.
    let mut fields = line.rsplit_once(')')?.1.split_whitespace();
    let state = fields.next()?;
    // State is field 3, the start field 22.
    fields.nth(18).filter(|_| !matches!(state, "Z" | "X")).map(str::to_owned)
}

fn host_name() -> String {
    let name = fs::read_to_string("/proc/sys/kernel/hostname").ok().map(|name| name.trim().to_owned());
    name.or_else(|| program_output("hostname", &[])).unwrap_or_default()
}

/// What systemd and D-Bus call a machine's identity (machine-id(5)), as a hash: it is not to be shown outside.
fn machine_identity() -> String {
    let identity =
        ["/etc/machine-id", "/var/lib/dbus/machine-id"].iter().find_map(|path| fs::read_to_string(path).ok());
    identity.filter(|text| !text.trim().is_empty()).map_or_else(String::new, |text| short_hash(text.trim()))
}

fn boot_and_namespace() -> String {
    let boot = fs::read_to_string("/proc/sys/kernel/random/boot_id").unwrap_or_default();
    let namespace = fs::read_link("/proc/self/ns/pid").unwrap_or_default();
    format!("{} {}", boot.trim(), namespace.display()).trim().to_owned()
}

/// What a program prints; none where it fails or prints nothing.
fn program_output(program: &str, arguments: &[&str]) -> Option<String> {
    // Dates are the same text whatever the language and the time zone of the process that asks.
    let ended = Command::new(program).args(arguments).env("LC_ALL", "C").env("TZ", "UTC").output().ok()?;
    let text = String::from_utf8_lossy(&ended.stdout).trim().to_owned();
    (ended.status.success() && !text.is_empty()).then_some(text)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn this_process_runs_and_one_of_the_same_number_that_started_at_another_time_does_not() {
        let this = Process::this();
        assert!(this.runs() && this.is_beside(&Process::this()));
        assert!(!Process { started: "0".into(), ..this.clone() }.runs());
        assert!(!Process { started: String::new(), ..this.clone() }.is_beside(&this));
    }

    #[test]
    fn a_process_of_an_earlier_boot_is_known_by_name_and_identity_of_the_machine() {
        let this = Process { system: "1".into(), machine: "boot pid:[1]".into(), ..Process::this() };
        let earlier = Process { machine: "former pid:[1]".into(), ..this.clone() };
        assert!(earlier.is_of_an_earlier_boot(&this) && !this.is_of_an_earlier_boot(&this));
        let container = Process { machine: "boot pid:[2]".into(), ..this.clone() };
        assert!(!container.is_of_an_earlier_boot(&this), "it runs beside this one");
        let host = "another".to_owned();
        for process in [Process { host, ..earlier.clone() }, Process { system: String::new(), ..earlier }] {
            assert!(!process.is_of_an_earlier_boot(&this));
        }
    }

    #[test]
    fn a_process_that_has_ended_does_not_run_before_its_parent_knows_either() {
        let mut child = Command::new("sleep").arg("60").spawn().unwrap();
        let process = Process { pid: child.id(), started: start_time(child.id()).unwrap(), ..Process::this() };
        assert!(process.runs());
        child.kill().unwrap();
        let gone = (0..500).any(|_| {
            std::thread::sleep(std::time::Duration::from_millis(2));
            !process.runs()
        });
        assert!(gone);
        child.wait().unwrap();
        assert!(!process.runs());
    }

    #[test]
    fn a_token_distinguishes_a_process_that_runs_from_one_that_has_ended() {
        let this = Process::this();
        assert!(!this.has_ended_here(&Process::this().token));
        let mut child = Command::new("sleep").arg("60").spawn().unwrap();
        let start = short_hash(&start_time(child.id()).unwrap());
        let token = format!("{}-{}-{start}-0", machine_hash(&this.host, &this.machine), child.id());
        assert!(!this.has_ended_here(&token));
        child.kill().unwrap();
        child.wait().unwrap();
        assert!(this.has_ended_here(&token));
        assert!(!this.has_ended_here(&token.replacen(&token[..8], "00000000", 1)), "of another machine");
        assert!(!this.has_ended_here("some file"));
    }

    #[test]
    fn the_start_is_read_behind_a_name_with_parentheses() {
        let line = |state: &str| format!("7 (a) b (c) {state} 1 7 7 0 -1 0 0 0 0 0 1 1 0 0 20 0 1 0 4242 0 0");
        assert_eq!(of_stat(&line("S")).as_deref(), Some("4242"));
        assert_eq!(of_stat(&line("Z")), None);
    }
}
