//! Cycles between the files of a crate: a file that imports from another must not be imported by it, directly or through others.
//!
//! Imports are read from `crate::` and `super::` paths outside of tests. A path through a module that re-exports an item is followed to the
//! file that defines it. A module and the files below it are one unit: a child may use what its parent declares.

use std::collections::{BTreeMap, BTreeSet};

use crate::assert_none;
use crate::source::Source;
use crate::tree::{crates, sources};

/// The modules of one crate: module path ("a/b") → code outside of tests.
type Modules = BTreeMap<String, String>;

/// Imports between modules, from → to.
type Imports = BTreeMap<String, BTreeSet<String>>;

fn modules(name: &str, files: &[Source]) -> Modules {
    let below = format!("pipeline/{name}/src/");
    let module = |s: &Source| {
        let path = s.path.strip_prefix(&below)?.trim_end_matches(".rs").to_owned();
        let path = path.strip_suffix("/mod").unwrap_or(&path).to_owned();
        (!s.test && path != "main").then(|| (path, s.outside_tests(&s.code())))
    };
    let with_module_name = |(path, code): (String, String)| (if path == "lib" { String::new() } else { path }, code);
    files.iter().filter_map(module).map(with_module_name).collect()
}

/// Every `crate::…` and `super::…` path in a module, as segments from the crate's root, groups in braces written out.
fn paths(module: &str, code: &str) -> Vec<Vec<String>> {
    let mut use_paths = Vec::new();
    for (start, word) in code.match_indices("crate::").chain(code.match_indices("super::")) {
        let preceding = code[..start].chars().next_back();
        if preceding.is_some_and(|c| c.is_alphanumeric() || c == '_' || c == ':') {
            continue;
        }
        let mut base: Vec<String> = Vec::new();
        let mut remainder = &code[start + word.len()..];
        if word == "super::" {
            base = module.split('/').filter(|part| !part.is_empty()).map(str::to_owned).collect();
            base.pop();
            while let Some(further) = remainder.strip_prefix("super::") {
                base.pop();
                remainder = further;
            }
        }
        expand(&base, remainder, &mut use_paths);
    }
    use_paths
}

/// Appends every path that a use tree beginning at `rest` names.
fn expand(base: &[String], rest: &str, found: &mut Vec<Vec<String>>) {
    let rest = rest.trim_start();
    if let Some(group) = rest.strip_prefix('{') {
        let (mut depth, mut from) = (1, 0);
        for (i, c) in group.char_indices() {
            match c {
                '{' => depth += 1,
                '}' => depth -= 1,
                _ => {}
            }
            if (c == ',' && depth == 1) || depth == 0 {
                expand(base, &group[from..i], found);
                from = i + 1;
            }
            if depth == 0 {
                return;
            }
        }
        return;
    }
    let word: String = rest.chars().take_while(|c| c.is_alphanumeric() || *c == '_').collect();
    if word.is_empty() || word == "self" {
        found.push(base.to_vec());
        return;
    }
    let longer: Vec<String> = base.iter().cloned().chain([word.clone()]).collect();
    match rest[word.len()..].strip_prefix("::") {
        Some(further) => expand(&longer, further, found),
        None => found.push(longer),
    }
}

/// The module that defines what a path names: the longest module on it, then through re-exports.
fn defining(modules: &Modules, path: &[String], depth: usize) -> Option<String> {
    let longest = (0..=path.len()).rev().find(|&n| modules.contains_key(&path[..n].join("/")))?;
    let module = path[..longest].join("/");
    let item = path.get(longest);
    let definition = item.filter(|_| depth < 8).and_then(|item| re_exported(modules, &module, item, depth));
    Some(definition.unwrap_or(module))
}

/// Where an item that a module re-exports is defined.
fn re_exported(modules: &Modules, module: &str, item: &str, depth: usize) -> Option<String> {
    let base: Vec<String> = module.split('/').filter(|part| !part.is_empty()).map(str::to_owned).collect();
    for line in modules[module].split(';') {
        let Some((_, used)) = line.split_once("pub use ").or_else(|| line.split_once("pub(crate) use ")) else {
            continue;
        };
        let used = used.trim().trim_start_matches("self::");
        let (base, used) = used.strip_prefix("crate::").map_or((base.clone(), used), |used| (Vec::new(), used));
        let mut reexported_paths = Vec::new();
        expand(&base, used, &mut reexported_paths);
        if let Some(path) = reexported_paths.iter().find(|path| path.last().is_some_and(|last| last == item)) {
            return defining(modules, path, depth + 1).filter(|found| found != module);
        }
    }
    None
}

/// Whether one module lies below the other: a parent and its children are one unit.
fn related(a: &str, b: &str) -> bool {
    let below =
        |outer: &str, inner: &str| outer.is_empty() || inner == outer || inner.starts_with(&format!("{outer}/"));
    below(a, b) || below(b, a)
}

fn imports(modules: &Modules) -> Imports {
    let targets_of = |(module, code): (&String, &String)| {
        let targets = paths(module, code).into_iter().filter_map(|path| defining(modules, &path, 0));
        (module.clone(), targets.filter(|target| !related(module, target)).collect())
    };
    modules.iter().map(targets_of).collect()
}

/// One cycle through each module that lies on one, each cycle once.
fn cycles(imports: &Imports) -> Vec<String> {
    let mut rotated_cycles = BTreeSet::new();
    for start in imports.keys() {
        if let Some(way) = way_back(imports, start) {
            let smallest = (0..way.len()).min_by_key(|&i| &way[i]).unwrap_or(0);
            let rotated: Vec<&str> = way[smallest..].iter().chain(&way[..smallest]).map(String::as_str).collect();
            rotated_cycles.insert(rotated.join(" → "));
        }
    }
    rotated_cycles.into_iter().collect()
}

/// The shortest way from a module back to itself.
fn way_back(imports: &Imports, start: &str) -> Option<Vec<String>> {
    let mut visited = BTreeSet::new();
    let mut ways = vec![vec![start.to_owned()]];
    while !ways.is_empty() {
        let mut longer = Vec::new();
        for way in ways {
            for next in imports.get(&way[way.len() - 1]).into_iter().flatten() {
                if next == start {
                    return Some(way);
                }
                if visited.insert(next.clone()) {
                    longer.push(way.iter().cloned().chain([next.clone()]).collect());
                }
            }
        }
        ways = longer;
    }
    None
}

#[test]
fn no_files_of_a_crate_import_each_other_in_a_circle() {
    let files = sources(&["pipeline"]);
    let module_cycles = |name: &String| {
        let crate_cycles = cycles(&imports(&modules(name, &files)));
        crate_cycles.into_iter().map(|cycle| format!("{name}: {cycle}")).collect::<Vec<_>>()
    };
    assert_none(crates().iter().flat_map(module_cycles).collect());
}

#[test]
fn a_cycle_through_a_re_export_is_found_and_a_child_that_uses_its_parent_is_none() {
    let file = |path: &str, text: &str| Source::new(&format!("pipeline/a/src/{path}.rs"), text);
    let files = [
        file("lib", "mod b;\nmod c;\npub use c::{Other, Thing};\n"),
        file("b/mod", "mod d;\nuse crate::Thing;\npub struct Own;\n"),
        file("b/d", "use super::Own;\n"),
        file("c", "use crate::b::Own;\npub struct Thing;\n#[cfg(test)]\nmod tests { use crate::e::X; }\n"),
        file("e", "use crate::c::Thing;\n"),
    ];
    assert_eq!(cycles(&imports(&modules("a", &files))), ["b → c"]);
}
