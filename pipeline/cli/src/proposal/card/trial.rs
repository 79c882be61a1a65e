//! `[[trial]]`: its files, and what its log says was done; and the true rate of the films.

use crate::proposal::columns::in_log_units;
use crate::proposal::experiment::Experiment;
use crate::proposal::guess::{Confidence, Guess};
use crate::proposal::trials::{Trial, Trials};

use super::Writer;

impl Writer {
    pub(super) fn trial(&mut self, trial: &Trial) {
        let about = |key: &str| format!("trial.{}.{key}", trial.id);
        self.put(format_args!("\n[[trial]]\nid = {:?}\n", trial.id));
        self.file("video", &trial.film.name, Guess { about: about("video"), ..trial.pairing.clone() });
        self.file("pressure", &trial.pressure.name, Guess { about: about("pressure"), ..trial.pairing.clone() });
        if let Some(force) = trial.force {
            self.file("force", &force.name, Guess { about: about("force"), ..trial.pairing.clone() });
        }
        trial.lags.iter().for_each(|lag| self.lag(lag));
        let names = format!("{} {}", trial.film.name, trial.pressure.name).to_lowercase();
        let has = |words: &[&str]| words.iter().any(|word| names.contains(word));
        let (medium, confidence, evidence) = match (has(&["water", "wasser", "tank"]), has(&["air", "luft", "dry"])) {
            (true, false) => ("water", Confidence::Likely, "the names of its files say so"),
            (false, true) => ("air", Confidence::Likely, "the names of its files say so"),
            _ => ("air", Confidence::Unsure, "no file says it: air or water"),
        };
        self.line("medium", Guess::new(confidence, about("medium"), format!("{medium:?}"), evidence));
        match &trial.done {
            Some((channels, done)) => self.experiment(trial, channels, done),
            None => self.guesses.push(Guess::question(about("kind"), "its log commands nothing")),
        }
    }

    /// A lag as a remark: the clocks are matched by the lamp, so that the card has no key for it.
    fn lag(&mut self, lag: &Guess) {
        let log = lag.about.rsplit('.').next().unwrap_or_default();
        let value = lag.value.as_deref().unwrap_or_default();
        self.put(format_args!("# lag of the {log} log = {value}  # {}\n", lag.remark()));
        self.guesses.push(lag.clone());
    }

    fn experiment(&mut self, trial: &Trial, channels: &[String], done: &Experiment) {
        let (unit, confidence, _) = trial.pressure.pressure_unit();
        let confidence = confidence.max(Confidence::Likely);
        let about = |key: &str| format!("trial.{}.{key}", trial.id);
        let entries = experiment_entries(channels, done, unit);
        for (key, value, evidence) in entries {
            self.line(key, Guess::new(confidence, about(key), value, evidence));
        }
        if matches!(done, Experiment::Staircase { pause: None, .. }) {
            self.question(&about(""), "pause", "nan", "s, 0 to 3600; its log shows a single level");
        }
        let role = if matches!(done, Experiment::Staircase { .. }) { "identify" } else { "validate" };
        let evidence = "no file says it: identify, validate or thrust";
        self.line("role", Guess::new(Confidence::Unsure, about("role"), format!("{role:?}"), evidence));
    }

    /// The true rate of the films.
    pub(super) fn rate(&mut self, trials: &Trials) {
        let Some(first) = trials.trials.first() else { return };
        let container = first.film.info.rate;
        let (seconds, confidence, evidence) = match trials.true_seconds {
            None => (1.0, Confidence::Likely, "by the films' containers; no lamp says it".to_owned()),
            Some(seconds) if (seconds - 1.0).abs() < 0.01 => {
                let is_sure = trials.trials.len() > 1;
                let evidence = "by the films' containers, and the lamp is on as long in films and logs".to_owned();
                (seconds, if is_sure { Confidence::Certain } else { Confidence::Likely }, evidence)
            }
            Some(seconds) => {
                let evidence = format!(
                    "the containers say {container:.2}, but a second of them is {seconds:.4} s of the logs: give their pictures with a times.csv"
                );
                (seconds, Confidence::Likely, evidence)
            }
        };
        let rate = format!("{:.2} frames/s", container / seconds);
        self.guesses.push(Guess::new(confidence, "frame rate", rate, evidence));
    }
}

/// Keys of a trial, their values and the evidence; `unit` is that of the commands.
fn experiment_entries(channels: &[String], done: &Experiment, unit: &str) -> Vec<(&'static str, String, String)> {
    let pascals = |level: f64| (level * in_log_units(unit) * 1000.0).round() / 10.0;
    let of_commands = format!("Pa; the commands, which are in {unit}");
    let mut entries = vec![("channels", format!("{channels:?}"), "those that its log commands".to_owned())];
    match done {
        Experiment::Staircase { levels, hold, pause } => {
            let levels: Vec<f64> = levels.iter().map(|level| pascals(*level)).collect();
            entries.push(("kind", "\"staircase\"".into(), "its levels follow each other with pauses".into()));
            entries.push(("levels", format!("{levels:?}"), of_commands));
            entries.push(("hold", format!("{hold:.3}"), "s; the median time of a level".into()));
            let pause = pause.map(|pause| ("pause", format!("{pause:.3}"), "s; the median time between two".into()));
            entries.extend(pause);
        }
        Experiment::Flapping { amplitude, frequency, cycles } => {
            let evidence = "Hz; from the beginnings of the levels of one channel";
            entries.push(("kind", "\"flapping\"".into(), "equal levels in turn".into()));
            entries.push(("amplitude", format!("{:?}", pascals(*amplitude)), of_commands));
            entries.push(("frequency", format!("{frequency:.3}"), evidence.into()));
            entries.push(("cycles", cycles.to_string(), "levels of one channel".into()));
        }
    }
    entries
}
