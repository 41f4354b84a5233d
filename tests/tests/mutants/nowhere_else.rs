//! No program of the workspace can contain a mutant: only these tests enable the feature.

use std::fs;
use std::path::Path;

#[test]
fn only_the_tests_enable_mutants() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
    let packages = [
        "wire",
        "controller",
        "emulators",
        "identification",
        "evaluation",
        "harness",
        "harness/campaign",
        "harness/campaign-nats",
        "harness/hil",
        "harness/hil-nats",
    ];
    for package in packages {
        let path = root.join(package).join("Cargo.toml");
        let text = fs::read_to_string(&path).expect("the package has a manifest");
        let manifest: toml::Table = toml::from_str(&text).expect("a manifest is TOML");
        for (section, value) in &manifest {
            // The features' own declarations have to name it.
            if section != "features" {
                assert!(!value.to_string().contains("mutants"), "{package}: [{section}]");
            }
        }
        let features = manifest.get("features").and_then(|features| features.as_table());
        for (feature, enables) in features.into_iter().flatten() {
            let forwards = feature == "mutants" || !enables.to_string().contains("mutants");
            assert!(forwards, "{package}: feature {feature} enables mutants");
        }
    }
    let text = fs::read_to_string(root.join("tests/Cargo.toml")).expect("there is one");
    let manifest: toml::Table = toml::from_str(&text).expect("a manifest is TOML");
    let enables = |section: &str| {
        manifest.get(section).is_some_and(|section| section.to_string().contains("mutants"))
    };
    assert!(enables("dev-dependencies") && !enables("dependencies"));
}
