//! A recording with other names, formats and units: the files as a laboratory of its own habits would have written them.

use std::fs;
use std::path::PathBuf;

use lab::card::{Experiment, Trial};
use lab::truth::Truth;

use super::recorded::Recorded;

/// The habits of a laboratory.
#[derive(Debug, Clone)]
pub struct Scheme {
    /// 0: counters in two folders, 1: dates in one folder, 2: a folder a trial, 3: named files in one folder.
    pub layout: u64,
    pub separator: char,
    /// 0: ASCII or UTF-8, 1: with a byte-order mark, 2: UTF-16, 3: Windows-1252.
    pub encoding: u64,
    /// 0: the guide's, 1: German with units in brackets, 2: English with a line of units.
    pub titles: u64,
    /// Word and what one of it is in our logs.
    pub pressure: (&'static str, f64),
    pub force: (&'static str, f64),
    pub time: (&'static str, f64),
    /// By how many columns the order is rotated.
    rotation: usize,
}

const PRESSURES: [(&str, f64); 4] = [("kPa", 10.0), ("mbar", 1.0), ("psi", 68.947_57), ("Pa", 0.01)];
const FORCES: [(&str, f64); 3] = [("mN", 1e-3), ("N", 1.0), ("gf", 9.806_65e-3)];
const TIMES: [(&str, f64); 3] = [("ms", 1e-3), ("s", 1.0), ("us", 1e-6)];

impl Scheme {
    pub fn of(seed: u64) -> Self {
        let titles = seed % 3;
        let pick = |all: &[(&'static str, f64)], salt: u64| {
            // the guide's titles hold their units
            let own = all.iter().find(|(_, factor)| *factor == 1.0).copied().unwrap();
            if titles == 0 { own } else { all[((seed / 3 + salt) % all.len() as u64) as usize] }
        };
        Self {
            layout: (seed + seed / 4) % 4,
            separator: [',', ';', '\t'][(seed / 2 % 3) as usize],
            encoding: (seed / 2 + seed / 3) % 4,
            titles,
            pressure: pick(&PRESSURES, 0),
            force: pick(&FORCES, seed / 5),
            time: pick(&TIMES, seed / 7),
            rotation: (seed % 5) as usize,
        }
    }

    /// Whether the dialect is said as it is.
    pub fn is_dialect(&self, said: &str) -> bool {
        let separator = match self.separator {
            '\t' => "tabs".to_owned(),
            sign => format!("`{sign}`"),
        };
        let encodings = [&["ASCII", "UTF-8,"][..], &["byte-order mark"], &["UTF-16"], &["Windows-1252", "ASCII"]];
        said.contains(&separator) && encodings[self.encoding as usize].iter().any(|name| said.contains(name))
    }

    /// The title and the unit of a quantity of the guide.
    fn title(&self, quantity: &str) -> (String, String) {
        let side = |english: &str| if english == "left" { "links" } else { "rechts" };
        let (pressure, force, time) = (self.pressure.0, self.force.0, self.time.0);
        let (german, english, unit) = match quantity {
            "time_s" => (format!("Zeit [{time}]"), "Time".to_owned(), time),
            "led" => ("Lampe".to_owned(), "Lamp".to_owned(), ""),
            "force_n" => (format!("Kraft [{force}]"), "Load cell".to_owned(), force),
            command if command.ends_with("_command_mbar") => {
                let name = command.trim_end_matches("_command_mbar");
                (format!("Soll {} [{pressure}]", side(name)), format!("{name} setpoint"), pressure)
            }
            measured => {
                let name = measured.trim_end_matches("_mbar");
                (format!("Druck ist {} [{pressure}]", side(name)), format!("{name} pressure"), pressure)
            }
        };
        match self.titles {
            0 => (quantity.to_owned(), String::new()),
            1 => (german, String::new()),
            _ => (english, unit.to_owned()),
        }
    }

    /// What a quantity is divided by.
    fn factor(&self, quantity: &str) -> f64 {
        match quantity {
            "time_s" => self.time.1,
            "led" => 1.0,
            "force_n" => self.force.1,
            _ => self.pressure.1,
        }
    }

    /// The name of a channel of the bench in these titles.
    fn channel(&self, name: &str) -> String {
        if self.titles == 1 { (if name == "left" { "links" } else { "rechts" }).to_owned() } else { name.to_owned() }
    }

    /// A log of the bench in this scheme.
    fn log(&self, text: &str) -> Vec<u8> {
        let mut lines = text.lines().filter(|line| !line.starts_with('#'));
        let quantities: Vec<&str> = lines.next().unwrap().split(',').collect();
        let order: Vec<usize> = (0..quantities.len()).map(|k| (k + self.rotation) % quantities.len()).collect();
        let separator = self.separator.to_string();
        let joined = |fields: Vec<String>| fields.join(&separator) + "\r\n";
        let titles: Vec<(String, String)> = order.iter().map(|k| self.title(quantities[*k])).collect();
        let mut all =
            joined(titles.iter().map(|(title, _)| title.clone()).chain(["Temperatur [°C]".to_owned()]).collect());
        if self.titles == 2 {
            all += &joined(titles.iter().map(|(_, unit)| unit.clone()).chain(["°C".to_owned()]).collect());
        }
        for line in lines {
            let values: Vec<f64> = line.split(',').map(|field| field.parse().unwrap()).collect();
            let number = |k: &usize| {
                let value = format!("{:.7}", values[*k] / self.factor(quantities[*k]));
                if self.separator == ',' { value } else { value.replace('.', ",") }
            };
            let warm = if self.separator == ',' { "21.5" } else { "21,5" };
            all += &joined(order.iter().map(number).chain([warm.to_owned()]).collect());
        }
        self.encoded(&all)
    }

    fn encoded(&self, text: &str) -> Vec<u8> {
        match self.encoding {
            0 => text.as_bytes().to_vec(),
            1 => [b"\xef\xbb\xbf", text.as_bytes()].concat(),
            2 => [0xfeff].into_iter().chain(text.encode_utf16()).flat_map(u16::to_le_bytes).collect(),
            _ => text.chars().map(|c| u8::try_from(u32::from(c)).unwrap()).collect(),
        }
    }

    /// The files of a recording: film, pressure log, force log.
    fn names(&self, number: usize, id: &str) -> [String; 3] {
        match self.layout {
            0 => [
                format!("cam/MOV_{:04}.mp4", 117 + number),
                format!("daq/p{}.txt", 8 + number),
                format!("daq/cell{}.txt", 3 + number),
            ],
            1 => [
                format!("2024-05-02 14.{:02} cam.mp4", 10 + 3 * number),
                format!("valve_2024-05-02_14{:02}.csv", 11 + 3 * number),
                format!("lc_2024-05-02_14{:02}.csv", 11 + 3 * number),
            ],
            2 => ["film.mp4", "valves.dat", "load.dat"].map(|name| format!("run {number}/{name}")),
            _ => [format!("{id}.MP4"), format!("{id} pressures.csv"), format!("{id} force.csv")],
        }
    }
}

/// A trial's files, and what was done in it.
pub struct TrialFiles {
    pub film: String,
    pub pressure: String,
    pub force: Option<String>,
    pub done: String,
    /// How far the clocks of the pressure log and of the force log are ahead of the film's, s.
    pub lags: [f64; 2],
}

impl TrialFiles {
    /// As the proposed trial is said.
    pub fn said(&self) -> String {
        format!("{} {} {}", self.pressure, self.force.as_deref().unwrap_or("none"), self.done)
    }
}

/// A changed folder, removed at the end.
pub struct Scrambled {
    pub folder: PathBuf,
    pub scheme: Scheme,
    pub calibration: String,
    pub lamp: [f64; 2],
    pub trials: Vec<TrialFiles>,
}

impl Scrambled {
    pub fn new(recorded: &Recorded, seed: u64) -> Self {
        let (scheme, specimen) = (Scheme::of(seed), &recorded.specimen);
        let folder = recorded.root.join(format!("folder_{seed}"));
        let copy = |from: &str, to: &str| write(&folder.join(to), &fs::read(specimen.file(from)).unwrap());
        let log = |from: &str, to: &str| {
            write(&folder.join(to), &scheme.log(&fs::read_to_string(specimen.file(from)).unwrap()));
        };
        let camera = specimen.card.camera.as_ref().unwrap();
        let [calibration, ..] = scheme.names(0, "checker board");
        copy(&camera.calibration, &calibration);
        let truth = lab::truth::read(&specimen.folder.join(lab::folder::TRUTH)).unwrap();
        let mut trials = Vec::new();
        for (k, trial) in specimen.card.trial.iter().enumerate() {
            let [film, pressure, force] = scheme.names(k + 1, &trial.id);
            copy(trial.video.as_ref().unwrap(), &film);
            log(&trial.pressure, &pressure);
            let force = trial.force.as_ref().map(|from| {
                log(from, &force);
                force
            });
            let lags = true_lags(&truth, &trial.id);
            trials.push(TrialFiles { film, pressure, force, done: done(trial, &scheme), lags });
        }
        copy("cad/body.stl", ["cad/body.stl", "Part1.STL"][(seed % 2) as usize]);
        copy("cad/spine.stl", ["cad/spine.stl", "Part2.STL"][(seed % 2) as usize]);
        write(&folder.join("notes.txt"), b"The lamp was new. See the book of May.\n");
        write(&folder.join("._notes.txt"), b"\0\x05\x16\x07");
        Self { folder, scheme, calibration, lamp: specimen.card.led.as_ref().unwrap().centre, trials }
    }

    /// Quantities of the logs with the kind of log and the unit that the card must name, empty where it is the guide's.
    pub fn units(&self) -> Vec<(String, &'static str, String)> {
        let unit = |(word, factor): (&str, f64)| if factor == 1.0 { String::new() } else { word.to_owned() };
        let left = self.scheme.channel("left");
        let mut units = vec![
            ("time_s".to_owned(), "pressure", unit(self.scheme.time)),
            (format!("{left}_command_mbar"), "pressure", unit(self.scheme.pressure)),
            (format!("{left}_mbar"), "pressure", unit(self.scheme.pressure)),
        ];
        let right = self.scheme.channel("right");
        units.push((format!("{right}_command_mbar"), "pressure", unit(self.scheme.pressure)));
        units.push((format!("{right}_mbar"), "pressure", unit(self.scheme.pressure)));
        if self.trials.iter().any(|trial| trial.force.is_some()) {
            units.push(("force_n".to_owned(), "force", unit(self.scheme.force)));
            units.push(("time_s".to_owned(), "force", unit(self.scheme.time)));
        }
        units
    }

    /// How far the clock of a film's log is ahead, s.
    pub fn lag_of(&self, film: &str, log: &str) -> f64 {
        let trial = self.trials.iter().find(|trial| trial.film == film).unwrap();
        trial.lags[usize::from(log == "force")]
    }

    /// The file of a film's trial under a key of the card.
    pub fn file_of(&self, film: &str, key: &str) -> String {
        let trial = self.trials.iter().find(|trial| trial.film == film);
        let file = trial.and_then(|trial| match key {
            "video" => Some(trial.film.clone()),
            "pressure" => Some(trial.pressure.clone()),
            "force" => trial.force.clone(),
            _ => None,
        });
        file.unwrap_or_else(|| "no file".to_owned())
    }
}

impl Drop for Scrambled {
    fn drop(&mut self) {
        let _ = fs::remove_dir_all(&self.folder);
    }
}

fn write(path: &PathBuf, bytes: &[u8]) {
    fs::create_dir_all(path.parent().unwrap()).unwrap();
    fs::write(path, bytes).unwrap();
}

/// What was done in a trial, as the test says it.
fn done(trial: &Trial, scheme: &Scheme) -> String {
    let (Experiment::Staircase { channels, .. } | Experiment::Flapping { channels, .. }) = &trial.experiment;
    let channels: Vec<String> = channels.iter().map(|channel| scheme.channel(channel)).collect();
    let channels = channels.join("+");
    match &trial.experiment {
        Experiment::Staircase { levels, hold, pause, .. } => {
            let levels: Vec<f64> = levels.iter().map(|level| (level / 100.0).round()).collect();
            let pause = if levels.len() > 1 { *pause } else { f64::NAN };
            format!("{channels} staircase {levels:?} {hold} {pause}")
        }
        Experiment::Flapping { amplitude, frequency, cycles, .. } => {
            format!("{channels} flaps {} kPa {} Hz {cycles}", (amplitude / 1e3).round(), frequency.round())
        }
    }
}

/// How far the clocks of a trial's logs are ahead of the film's when the lamp lights, s; of a log that there is not, NaN.
fn true_lags(truth: &Truth, id: &str) -> [f64; 2] {
    let trial = truth.trial.iter().find(|trial| trial.id == id).unwrap();
    let lag = |offset: f64, scale: f64| offset + (scale - 1.0) * trial.led_on;
    let force = truth.force.iter().find(|force| force.id == id);
    [lag(trial.clock_offset, trial.clock_scale), force.map_or(f64::NAN, |log| lag(log.clock_offset, log.clock_scale))]
}
