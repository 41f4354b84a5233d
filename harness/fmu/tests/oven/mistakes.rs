//! Mistakes in an FMU, or in what a device file says of it, are found when the file is read, with their place.

use crate::{DEVICE, folder, read};
use fmu::samples;

/// The message, and the place in the device file.
fn mistake(folder: &tempfile::TempDir, text: &str) -> (String, String) {
    let error = read(folder, text).unwrap_err();
    (error.message().to_owned(), text[error.range()].to_owned())
}

#[test]
fn an_fmu_that_cannot_be_used_is_shown_at_its_name() {
    let folder = folder(2);
    let path = folder.path().join("oven.fmu");
    let whole = std::fs::read(&path).unwrap();
    let refused = |expected: &str| {
        let (message, place) = mistake(&folder, DEVICE);
        assert!(message.contains(expected), "{message}");
        assert_eq!(place, "\"oven.fmu\"");
    };
    let described = |change: &dyn Fn(&str) -> String| samples::oven(&path, 2, change);

    described(&|text| text.replace("fmiVersion=\"2.0\"", "fmiVersion=\"1.0\""));
    refused("it is of FMI 1.0, expected 2.0 or 3.0");
    described(&|text| text.replace("CoSimulation ", "ModelExchange "));
    refused("it is for model exchange, expected co-simulation");
    described(&|text| text.replace("</ModelVariables>", ""));
    refused("its modelDescription.xml is no XML: ");
    described(&|text| text.replace("valueReference=\"3\"", "valueReference=\"-3\""));
    refused("`-3` is no valueReference, at its variable `ambient`");
    described(&|text| text.replace("modelIdentifier=\"oven\"", "modelIdentifier=\"../oven\""));
    refused("`../oven` is no modelIdentifier");
    described(&|text| text.replace("modelIdentifier=\"oven\"", "modelIdentifier=\"pan\""));
    refused("it has libraries for linux64, expected binaries/linux64/pan.so");

    let description = samples::DESCRIPTIONS[0].as_bytes();
    let with = |library: &str, bytes: &[u8]| {
        fmu::write(&path, [("modelDescription.xml", description), (library, bytes)]).unwrap();
    };
    with("binaries/win64/oven.dll", b"MZ");
    refused("it has libraries for win64, expected binaries/linux64/oven.so");
    with("sources/oven.c", b"int x;");
    refused("it has no library, expected binaries/linux64/oven.so");
    with("binaries/linux64/oven.so", b"\x7fELF and no more");
    refused("failed to load its library: oven.so: ");
    with("binaries/linux64/oven.so", &samples::library(3));
    refused("its library has no fmi2Instantiate");
    fmu::write(&path, [("readme.txt", b"".as_slice())]).unwrap();
    refused("it has no modelDescription.xml");
    std::fs::write(&path, &whole[..whole.len() / 2]).unwrap();
    refused("it is no FMU: ");
    // One bit of the library: checksums of the archive tell.
    let mut damaged = whole.clone();
    damaged[whole.len() / 2] ^= 1;
    std::fs::write(&path, damaged).unwrap();
    refused("failed to unpack `binaries/linux64/oven.so`: ");
    std::fs::remove_file(&path).unwrap();
    refused("No such file or directory");
}

#[test]
fn what_the_file_says_of_it_is_checked() {
    let folder = folder(3);
    for (from, to, expected, place) in [
        ("power = ", "powr = ", "the FMU has no input `powr`", "powr"),
        ("power = ", "steps = ", "`steps` of the FMU is no input: it is an output", "steps"),
        (
            "\"temperature\"",
            "\"power\"",
            "`power` of the FMU is no output: it is an input",
            "inside",
        ),
        ("\"temperature\"", "\"nothing\"", "the FMU has no output `nothing`", "inside"),
        ("{ ambient", "{ label = 1, ambient", "`label` of the FMU is a String", "label"),
        ("{ ambient", "{ profile = 1, ambient", "`profile` of the FMU is an array", "profile"),
        ("\"t < 2\"", "\"t < to\"", "no variable `to`", "to"),
        (
            "\"room\"",
            "\"Power\"",
            "`Power` is not a parameter, and a start is made of those alone",
            "Power",
        ),
        ("inside =", "room =", "there is a parameter `room` already", "room"),
        ("inside =", "exp =", "`exp` has a meaning in every expression", "exp"),
        ("expression = \"inside\"", "expression = \"is_hot\"", "", ""),
        (
            "unit = \"degC\"",
            "unit = \"K\"",
            "`Temperature` is in K, and `inside` in degC",
            "\"inside\"",
        ),
        ("outputs = {", "outputs = {}\n# {", "nothing reads the FMU", "fmu"),
        ("[fmu]", "[fmu]\nstep_s = 0", "0 s is not a time here", "0"),
        (
            "[[message]]",
            "[machine.m]\nstates = [\"a\", \"b\"]\nstart = \"a\"\ntransitions = [{ to = \"b\", after_s = 1, set = { inside = 1 } }]\n[[message]]",
            "a machine sets `inside`, which is an output of the FMU",
            "inside",
        ),
    ] {
        let text = DEVICE.replacen(from, to, 1);
        if expected.is_empty() {
            read(&folder, &text).unwrap();
            continue;
        }
        assert_eq!(mistake(&folder, &text), (expected.to_owned(), place.to_owned()), "{to}");
    }
}
