//! Sections and keys of `study.toml` under their former names.

use workflow::settings::Renamed;

/// Each is refused with its present name.
pub(crate) const RENAMED: &[Renamed] = &[
    Renamed { section: "", old: "best_flap", new: "optimal_actuation" },
    Renamed { section: "", old: "damping", new: "relaxation" },
    Renamed { section: "", old: "mesh_honesty", new: "mesh_sensitivity" },
    Renamed { section: "", old: "still", new: "example_frames" },
    Renamed { section: "clock", old: "log_mean", new: "log_averaging" },
    Renamed { section: "drag", old: "added", new: "added_mass_ratio" },
    Renamed { section: "drag", old: "drag", new: "normal_drag_coefficient" },
    Renamed { section: "drag", old: "follow", new: "duration" },
    Renamed { section: "four_parameters", old: "side_by_side", new: "parallel_solves" },
    Renamed { section: "identify", old: "adam_iterations", new: "method_comparison.adam_iterations" },
    Renamed { section: "identify", old: "adam_mean_decay", new: "method_comparison.adam_mean_decay" },
    Renamed { section: "identify", old: "adam_mean_memory", new: "method_comparison.adam_mean_decay" },
    Renamed { section: "identify", old: "adam_square_decay", new: "method_comparison.adam_square_decay" },
    Renamed { section: "identify", old: "adam_square_memory", new: "method_comparison.adam_square_decay" },
    Renamed { section: "identify", old: "adam_step", new: "method_comparison.adam_step" },
    Renamed { section: "identify", old: "adam_step_decay", new: "method_comparison.adam_step_decay" },
    Renamed { section: "identify", old: "cma_es_generations", new: "method_comparison.cma_es_generations" },
    Renamed { section: "identify", old: "cma_es_seed", new: "method_comparison.cma_es_seed" },
    Renamed { section: "identify", old: "compared", new: "method_comparison.specimens" },
    Renamed { section: "identify", old: "grid_points", new: "method_comparison.grid_points" },
    Renamed { section: "identify", old: "landscape_points", new: "method_comparison.landscape_points" },
    Renamed { section: "identify", old: "settled", new: "settled_fraction" },
    Renamed { section: "identify", old: "share", new: "scale_sigma" },
    Renamed { section: "identify", old: "side_by_side", new: "parallel_solves" },
    Renamed { section: "load_cell", old: "shown_beat", new: "example_frequency" },
    Renamed { section: "load_cell", old: "shown_peak", new: "example_peak" },
    Renamed { section: "load_cell", old: "smooth", new: "cutoff" },
    Renamed { section: "mesh_sensitivity", old: "beyond", new: "modulus_factor" },
    Renamed { section: "mesh_sensitivity", old: "highest", new: "pressure_fraction" },
    Renamed { section: "optimal_actuation", old: "beats", new: "cycles" },
    Renamed { section: "optimal_actuation", old: "drag", new: "normal_drag_coefficient" },
    Renamed { section: "optimal_actuation", old: "per_beat", new: "steps_per_cycle" },
    Renamed { section: "optimal_actuation", old: "rounds", new: "iterations" },
    Renamed { section: "thrust", old: "aside", new: "validation_fraction" },
    Renamed { section: "thrust", old: "hidden", new: "hidden_layers" },
    Renamed { section: "thrust", old: "rest_hidden", new: "residual_hidden_layers" },
    Renamed { section: "thrust", old: "settle_beats", new: "settling_cycles" },
    Renamed { section: "thrust", old: "smooth", new: "cutoff" },
    Renamed { section: "thrust", old: "undo", new: "deconvolve" },
    Renamed { section: "thrust", old: "undo_smooth", new: "deconvolution_cutoff" },
    Renamed { section: "thrust", old: "undo_weight", new: "deconvolution_weight" },
    Renamed { section: "track", old: "agreement_limit", new: "flow_centroid_limit" },
    Renamed { section: "track", old: "company_limit", new: "neighbour_distance_limit" },
    Renamed { section: "track", old: "hidden_limit", new: "longest_occlusion" },
    Renamed { section: "track", old: "likeness_limit", new: "correlation_limit" },
    Renamed { section: "track", old: "reach", new: "click_radius" },
    Renamed { section: "track", old: "return_limit", new: "forward_backward_limit" },
    Renamed { section: "validate", old: "checked", new: "whole_model_duration" },
    Renamed { section: "wave", old: "guarded", new: "guarded_harmonics" },
    Renamed { section: "wave", old: "settle", new: "settling_time" },
];

#[cfg(test)]
mod tests {
    use super::*;
    use toml::{Table, Value};

    const STUDY: &str = include_str!("../../../study.toml");

    /// Whether the settings have a section, or a key of one.
    fn has(settings: &Table, section: &str, key: &str) -> bool {
        if section.is_empty() {
            return settings.contains_key(key);
        }
        settings.get(section).and_then(Value::as_table).is_some_and(|keys| keys.contains_key(key))
    }

    #[test]
    fn every_former_name_leads_to_a_present_one_and_is_none_itself() {
        let settings: Table = STUDY.parse().unwrap();
        for &Renamed { section, old, new } in RENAMED {
            let (moved, key) = new.split_once('.').unwrap_or((section, new));
            assert!(has(&settings, moved, key), "[{section}] {old} leads to {new}, which is not in study.toml");
            assert!(!has(&settings, section, old), "[{section}] {old} is in study.toml");
        }
    }

    #[test]
    fn no_former_name_is_listed_twice() {
        let names = RENAMED.iter().map(|r| (r.section, r.old));
        assert_eq!(names.clone().collect::<std::collections::BTreeSet<_>>().len(), names.count());
    }
}
