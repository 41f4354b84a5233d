//! No two files of a crate need each other, whether at once or by way of others: each can be read after those that it
//! names. Left out is what a module and the files within it name of each other.

mod names;

use names::Names;
use std::collections::{BTreeMap, BTreeSet};
use tests::rooms::{members, root};

/// A list of words and the words in it know each other.
const LISTS: [&str; 1] = ["harness/plan/src/step/op.rs"];

type Arrows = BTreeMap<usize, BTreeSet<usize>>;

fn reached(arrows: &Arrows, from: usize) -> BTreeSet<usize> {
    let mut seen = BTreeSet::new();
    let mut next = vec![from];
    while let Some(file) = next.pop() {
        next.extend(arrows[&file].iter().filter(|to| seen.insert(**to)));
    }
    seen
}

/// The arrows between files that reach themselves, as text.
fn circles(names: &Names) -> Vec<String> {
    let name = |file: usize| {
        let path = names.files[file].strip_prefix(root()).expect("it is below the root");
        path.to_string_lossy().into_owned()
    };
    let mut arrows = names.arrows();
    arrows.retain(|file, _| !LISTS.contains(&name(*file).as_str()));
    let kept: BTreeSet<usize> = arrows.keys().copied().collect();
    for to in arrows.values_mut() {
        to.retain(|file| kept.contains(file));
    }
    let all: BTreeMap<usize, BTreeSet<usize>> =
        kept.iter().map(|file| (*file, reached(&arrows, *file))).collect();
    let both = |a: &usize, b: &usize| all[a].contains(b) && all[b].contains(a);
    let pairs = arrows.iter().flat_map(|(a, to)| to.iter().map(move |b| (a, b)));
    pairs
        .filter(|(a, b)| both(a, b))
        .map(|(a, b)| format!("{} -> {}", name(*a), name(*b)))
        .collect()
}

#[test]
fn no_file_needs_one_that_needs_it() {
    let mut found = Vec::new();
    let mut crates = 0;
    for member in members() {
        let roots = ["lib.rs", "main.rs", "bin/k2a-controller/main.rs"];
        for root in roots.map(|name| root().join(&member).join("src").join(name)) {
            if root.exists() {
                crates += 1;
                found.extend(circles(&Names::of(&root)));
            }
        }
    }
    assert!(crates > 25 && found.is_empty(), "{crates} crates, circles:\n{}", found.join("\n"));
}

#[test]
fn a_circle_is_seen_through_imports_and_re_exports() {
    let folder = tempfile::tempdir().unwrap();
    let write = |name: &str, text: &str| {
        std::fs::write(folder.path().join(name), text).unwrap();
    };
    write("lib.rs", "mod a;\nmod b;\nmod c;\npub use b::B;\n");
    write("a.rs", "use crate::B;\npub struct A(B);\n");
    write("b.rs", "pub struct B(Option<Box<super::c::C>>);\n");
    let arrows = |c: &str| {
        write("c.rs", c);
        let names = Names::of(&folder.path().join("lib.rs"));
        let arrows = names.arrows();
        (0..names.files.len()).any(|file| reached(&arrows, file).contains(&file))
    };
    assert!(!arrows("pub struct C;\n"));
    assert!(arrows("use super::*;\npub struct C(a::A);\n"));
    assert!(arrows("use crate::a::A as Other;\npub struct C(Other);\n"));
    assert!(!arrows("pub struct C;\n#[cfg(test)]\nmod tests { use crate::a::A; }\n"));
}
