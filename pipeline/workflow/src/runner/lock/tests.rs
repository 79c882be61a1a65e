//! Locks among threads that act as processes, and locks of processes that are gone.

use std::sync::atomic::{AtomicUsize, Ordering};

use super::*;

struct Folder(PathBuf);

impl Folder {
    fn new(name: &str) -> Self {
        let path = std::env::temp_dir().join(format!("lock-{name}-{}", std::process::id()));
        let _ = fs::remove_dir_all(&path);
        fs::create_dir_all(&path).unwrap();
        Self(path)
    }

    fn holder(&self) -> Holder {
        Holder::enter(&self.0.join("holders")).unwrap()
    }

    /// A lock whose holder is as `change` makes it, of this age.
    fn left(&self, age: Duration, change: impl Fn(&mut Process)) -> PathBuf {
        let mut process = Process { token: "left".into(), ..Process::this() };
        change(&mut process);
        let path = self.0.join("a.lock");
        fs::write(&path, serde_json::to_vec(&process).unwrap()).unwrap();
        File::options().append(true).open(&path).unwrap().set_modified(SystemTime::now() - age).unwrap();
        path
    }
}

impl Drop for Folder {
    fn drop(&mut self) {
        let _ = fs::remove_dir_all(&self.0);
    }
}

fn is_free(holder: &Holder, path: &Path) -> bool {
    matches!(holder.ask(path).unwrap(), Attempt::Held(_))
}

const YOUNG: Duration = Duration::from_secs(60);

fn ended(process: &mut Process) {
    process.started = "0".into();
}

fn of_another_machine(process: &mut Process) {
    process.machine = "another".into();
    process.system = "another".into();
}

#[test]
fn a_lock_is_held_by_one_until_it_is_dropped_and_leaves_nothing() {
    let folder = Folder::new("one");
    let (first, second, path) = (folder.holder(), folder.holder(), folder.0.join("a.lock"));
    let lock = first.ask(&path).unwrap();
    assert!(!is_free(&second, &path) && !is_free(&first, &path));
    drop(lock);
    assert!(is_free(&second, &path) && !path.exists());
    drop((first, second));
    assert_eq!(fs::read_dir(folder.0.join("holders")).unwrap().count(), 0);
}

#[test]
fn the_lock_of_a_process_that_has_ended_here_is_taken_at_once_and_that_of_another_machine_after_its_age() {
    let folder = Folder::new("abandoned");
    let holder = folder.holder();
    assert!(is_free(&holder, &folder.left(Duration::ZERO, ended)));
    assert!(!is_free(&holder, &folder.left(2 * AGE_LIMIT, |_| {})), "it runs, however old its lock");
    assert!(!is_free(&holder, &folder.left(YOUNG, of_another_machine)));
    assert!(is_free(&holder, &folder.left(2 * AGE_LIMIT, of_another_machine)));
}

#[test]
fn a_lock_of_the_future_or_of_an_earlier_boot_is_taken_at_once() {
    let folder = Folder::new("future");
    let (holder, path) = (folder.holder(), folder.left(Duration::ZERO, of_another_machine));
    File::options().append(true).open(&path).unwrap().set_modified(SystemTime::now() + 2 * AGE_LIMIT).unwrap();
    assert!(is_free(&holder, &path));
    let path = folder.left(Duration::ZERO, |process| {
        (process.machine, process.system) = ("former pid:[1]".into(), "1".into());
    });
    let mut rebooted = folder.holder();
    rebooted.process.system = "1".into();
    assert!(is_free(&rebooted, &path));
}

#[test]
fn a_lock_that_is_not_understood_is_held_for_seconds() {
    let folder = Folder::new("unreadable");
    let (holder, path) = (folder.holder(), folder.0.join("a.lock"));
    for text in ["", "{"] {
        fs::write(&path, text).unwrap();
        assert!(!is_free(&holder, &path));
        let date = SystemTime::now() - 2 * AGE_LIMIT_OF_NO_PROCESS;
        File::options().append(true).open(&path).unwrap().set_modified(date).unwrap();
        assert!(is_free(&holder, &path));
    }
    // whatever the dates of the file server are
    fs::write(&path, "{").unwrap();
    let later = folder.holder();
    assert!(!is_free(&later, &path));
    std::thread::sleep(AGE_LIMIT_OF_NO_PROCESS + Duration::from_millis(200));
    assert!(is_free(&later, &path));
}

#[cfg(unix)]
#[test]
fn a_folder_or_a_fifo_in_the_place_of_a_lock_is_refused_with_what_to_remove() {
    let folder = Folder::new("special");
    let (holder, path) = (folder.holder(), folder.0.join("a.lock"));
    for (program, kind) in [("mkdir", "a folder"), ("mkfifo", "a FIFO")] {
        assert!(std::process::Command::new(program).arg(&path).status().unwrap().success());
        let Err(refused) = holder.ask(&path) else { panic!("{kind} is no lock") };
        let text = refused.to_string();
        assert!(text.contains(kind) && text.contains(&format!("remove {}", path.display())), "{text}");
        fs::remove_dir(&path).or_else(|_| fs::remove_file(&path)).unwrap();
    }
}

#[test]
fn the_empty_file_of_a_process_that_was_killed_while_it_entered_is_removed_by_the_next() {
    let folder = Folder::new("entered");
    drop(folder.holder());
    let this = Process::this();
    let ended = this.token.replacen(&format!("-{}-", this.pid), "-0-", 1);
    let names = [ended, this.token];
    names.iter().for_each(|name| fs::write(folder.0.join("holders").join(name), "").unwrap());
    let _holder = folder.holder();
    let remaining = names.map(|name| folder.0.join("holders").join(name).exists());
    assert_eq!(remaining, [false, true], "the second is of a process that runs");
}

#[test]
fn a_process_killed_while_it_removed_an_abandoned_lock_is_followed_by_the_next() {
    let folder = Folder::new("chain");
    let holder = folder.holder();
    let path = folder.left(Duration::ZERO, ended);
    let mut right = read_owner(&path).unwrap().unwrap();
    right.token = "right".into();
    let text = serde_json::to_vec(&right).unwrap();
    fs::write(right_to_remove(&path, &read_owner(&path).unwrap().unwrap()), &text).unwrap();
    fs::write(folder.0.join("a.lock.gone"), &text).unwrap();
    let Attempt::Held(lock) = holder.ask(&path).unwrap() else { panic!("both of its holders have ended") };
    lock.sweep();
    drop(lock);
    let remaining: Vec<_> = fs::read_dir(&folder.0).unwrap().map(|e| e.unwrap().file_name()).collect();
    assert_eq!(remaining, ["holders"]);
}

#[test]
fn of_many_that_find_an_abandoned_lock_one_holds_it_at_a_time() {
    const ROUNDS: usize = 60;
    const THREADS: usize = 8;
    let folder = Folder::new("race");
    for _ in 0..ROUNDS {
        let path = folder.left(Duration::ZERO, ended);
        let (inside, entered) = (AtomicUsize::new(0), AtomicUsize::new(0));
        let compete = || {
            let holder = folder.holder();
            loop {
                if let Attempt::Held(_lock) = holder.ask(&path).unwrap() {
                    assert_eq!(inside.fetch_add(1, Ordering::SeqCst), 0, "two hold the lock");
                    std::thread::yield_now();
                    inside.fetch_sub(1, Ordering::SeqCst);
                    break;
                }
                std::thread::yield_now();
            }
            entered.fetch_add(1, Ordering::SeqCst);
        };
        std::thread::scope(|scope| (0..THREADS).for_each(|_| drop(scope.spawn(compete))));
        assert_eq!(entered.into_inner(), THREADS);
    }
}

#[test]
fn a_lock_that_was_taken_away_is_seen_and_not_released() {
    let folder = Folder::new("lost");
    let (holder, path) = (folder.holder(), folder.0.join("a.lock"));
    let Attempt::Held(lock) = holder.ask(&path).unwrap() else { panic!("nobody holds it") };
    fs::remove_file(&path).unwrap();
    folder.left(Duration::ZERO, of_another_machine);
    assert!(!lock.is_held());
    drop(lock);
    assert!(path.exists());
}
