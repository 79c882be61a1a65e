//! A project of its own with one tail, recorded and studied as coarsely as every stage still works.

use std::fs;
use std::path::{Path, PathBuf};

use lab::card::Medium;
use rig::progress::Progress;
use rig::record::{Request, Status, record};
use rig::settings::{FlappingTrial, Profile, RepeatSplit, Resolution, Settings};
use rig::specimen::Specimen;
use study::Runner;
use tail_cad::Tail;
use workflow::runner::Options;

const OPTIONS: Options = Options { quiet: true, jobs: Some(2), memory: None, keep_going: true, min_free_memory: 0.0 };

/// The project, removed at the end.
pub struct Project(pub PathBuf);

impl Project {
    /// With the recording of a coarse Nemo.
    pub fn recorded(name: &str) -> Self {
        let root = std::env::temp_dir().join(format!("study-{name}-{}", std::process::id()));
        let house = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("..");
        fs::create_dir_all(root.join("data/raw")).unwrap();
        fs::create_dir_all(root.join("paper")).unwrap();
        for page in ["paper/claims.toml", "paper/expected.toml"] {
            fs::copy(house.join(page), root.join(page)).unwrap();
        }
        fs::write(root.join("study.toml"), coarse(&fs::read_to_string(house.join("study.toml")).unwrap())).unwrap();
        let project = Self(root);
        record_into(&project.0.join("data/raw"));
        project
    }

    pub fn open(&self) -> Runner {
        let (runner, diagnostics) = study::open(&self.0, workflow::settings::Profile::Paper, OPTIONS).unwrap();
        assert!(diagnostics.is_empty(), "{diagnostics:?}");
        runner
    }
}

impl Drop for Project {
    fn drop(&mut self) {
        let _ = fs::remove_dir_all(&self.0);
    }
}

/// The study's settings with those of [`COARSE`].
fn coarse(settings: &str) -> String {
    let (mut all, changed): (toml::Table, toml::Table) = (settings.parse().unwrap(), COARSE.parse().unwrap());
    for (section, keys) in changed {
        let here = all[&section].as_table_mut().unwrap();
        keys.as_table().unwrap().iter().for_each(|(key, value)| drop(here.insert(key.clone(), value.clone())));
    }
    toml::to_string(&all).unwrap()
}

const COARSE: &str = r#"
[mesh]
elements = "tetrahedra"
edge = 0.010
[identify]
fine_edge = 0.006
settled_fraction = 0.5
[method_comparison]
specimens = ["nemo"]
grid_points = 3
cma_es_generations = 2
adam_iterations = 3
surface_points = 4
landscape_points = 5
[four_parameters]
iterations = 10
[mesh_sensitivity]
edges = [0.007, 0.009]
iterations = 8
[inflate]
shapes = 6
[relaxation]
highest_level = 1.0
iterations = 3
[validate]
euler_step = 0.016666666666666666
whole_model_duration = 0.05
[thrust]
hidden_layers = [20, 20]
residual_hidden_layers = [8, 8]
batch = 16
epochs = 20
seeds = [1]
[optimal_actuation]
scan = [2, 2]
iterations = 2
waveform_iterations = 2
"#;

fn record_into(raw: &Path) {
    let mut set = Settings::built_in();
    let specimen = Specimen { name: "nemo".into(), tail: three_chambers, draw: None };
    let profile = Profile {
        specimens: vec![specimen.name.to_string()],
        resolution: Resolution { edge: 0.010, per_chamber: 3, per_rib: 1, hexahedra: None },
        levels: 6,
        step: 1.0 / 240.0,
        rest: 0.25,
        hold: 0.5,
        pause: 0.3,
        cycles: 3,
        repeats: 1,
        brief: false,
        poses: 8,
    };
    let own = set.specimen.get_mut(&*specimen.name).unwrap();
    own.body = "dragon_skin_10_less_stiffening".into();
    (own.levels, own.levels_in_water) = (vec![8000.0, 16000.0], vec![12000.0]);
    own.flaps = vec![
        flap(Medium::Air, 2.0, (None, true)),
        flap(Medium::Water, 2.0, (Some(RepeatSplit::Train), true)),
        flap(Medium::Water, 3.0, (Some(RepeatSplit::Test), false)),
    ];
    set.profile.insert("coarse".to_owned(), profile);
    let progress = Progress::new(true);
    let request = Request { set: &set, profile: "coarse", into: raw, progress: &progress };
    assert_eq!(record(&specimen, &request).unwrap_or_else(|e| panic!("{e}")), Status::Recorded);
}

/// As few elements as a tail can have: three chambers a side in the outer shape of the bench's tails, with walls that do not balloon.
fn three_chambers() -> Tail {
    Tail {
        chambers: 3,
        rib: 5e-3,
        wall: [3e-3; 2],
        inner_wall: 0.5e-3,
        top_wall: 3e-3,
        sheet: 0.9e-3,
        ..Tail::nine_chambers()
    }
}

fn flap(medium: Medium, frequency: f64, (split, validate): (Option<RepeatSplit>, bool)) -> FlappingTrial {
    FlappingTrial { medium, pressure: 16000.0, frequency, split, validate, brief: true }
}
