//! An emulated gyro can learn what an identification finds about a gyro.

#![expect(clippy::unwrap_used, reason = "a test that cannot go on fails")]

use identification::model::Model;
use plan::device_files::{DevicesError, load_devices};
use plan::library::Library;
use plan::models::to_toml;

/// Returns a model with these terms, each given as the body of a `[[terms]]`.
fn model(terms: &[&str]) -> Model {
    let head = "schema = 1\nkind = 'turns'\n[fields]\ncoil = 'temperature'\nspin = 'table_rate'\n";
    let terms = terms.iter().map(|term| format!("[[terms]]\n{term}\n"));
    toml::from_str(&(head.to_owned() + &terms.collect::<String>())).unwrap()
}

const SHUPE: &str = "name = 't'\nterm = 'bias'\ndrivers = ['rate_of(coil)']\nform = 'linear'\n\
                     parameters = [{ name = 'h', value = 1, unit = 'deg/s/(K/s)' }]";
const DELAY: &str = "name = 't'\nterm = 'delay'\ndrivers = ['spin']\nform = 'delay'\n\
                     parameters = [{ name = 'delay', value = 0.01, unit = 's' }]";
const NOISE: &str = "name = 't'\nterm = 'noise'\ndrivers = []\nform = 'constant'\n\
                     parameters = [{ name = 'value', value = 1, unit = 'deg/h' }]";

#[test]
fn a_device_file_names_the_model_that_its_gyro_has_learned() {
    let folder = tempfile::tempdir().unwrap();
    for sub in ["devices", "models"] {
        std::fs::create_dir(folder.path().join(sub)).unwrap();
    }
    let write = |path: &str, text: &str| std::fs::write(folder.path().join(path), text).unwrap();
    write(
        "devices/taught.toml",
        "title = 'x'\nmount = 'table'\n[gyro]\nmodel = 'navigator'\nlearned = 'unit'\n\
         [table]\nmodel = 'stepper'\n",
    );
    let library = Library::beside(folder.path().join("plan.toml").to_str().unwrap());
    let of = |model: &Model| {
        write("models/unit.toml", &to_toml(model, "by hand"));
        load_devices(&library, "taught")
    };
    assert!(matches!(load_devices(&library, "taught"), Err(DevicesError::Library(_))));
    let gyro = of(&model(&[SHUPE, DELAY])).unwrap().gyro.1;
    assert_eq!((gyro.terms.len(), gyro.latency_s), (1, 0.01));
    let refused = of(&model(&[NOISE])).unwrap_err().to_string();
    assert!(refused.contains("term `t` cannot be carried"), "{refused}");
}
