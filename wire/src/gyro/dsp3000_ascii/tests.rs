use super::super::test_support::{decoded, rate_sample};
use super::encode;
use crate::gyro::{GyroFormat, GyroOutput, GyroSample, OutputMode};
use crate::units::{Angle, AngularRate};
use insta::assert_snapshot;
use std::string::{String, ToString};
use std::vec::Vec;

fn line(sample: GyroSample) -> String {
    encode(&sample).as_slice().escape_ascii().to_string()
}

fn angle(deg: f64) -> GyroSample {
    GyroSample { output: GyroOutput::Integrated(Angle::from_deg(deg)), ..rate_sample(0.0) }
}

fn read(text: &[u8], mode: OutputMode) -> Vec<GyroOutput> {
    let samples = decoded(GyroFormat::Dsp3000Ascii, mode, text);
    samples.iter().map(|sample| sample.output).collect()
}

#[test]
fn known_lines() {
    assert_snapshot!(line(rate_sample(0.0)), @r"       0.000000   1\r\n");
    assert_snapshot!(line(rate_sample(30.0)), @r"      30.000000   1\r\n");
    assert_snapshot!(line(rate_sample(-30.0)), @r"     -30.000000   1\r\n");
    assert_snapshot!(line(rate_sample(-0.000_001)), @r"      -0.000001   1\r\n");
    assert_snapshot!(line(rate_sample(-0.000_000_1)), @r"       0.000000   1\r\n");
    assert_snapshot!(line(rate_sample(1e9)), @r"     999.999999   1\r\n");
    assert_snapshot!(line(rate_sample(-1e9)), @r"    -999.999999   1\r\n");
    assert_snapshot!(line(rate_sample(f64::NAN)), @r"       0.000000   0\r\n");
    assert_snapshot!(line(angle(-90.0)), @r"     270.000000   1\r\n");
    assert_snapshot!(line(angle(719.999_999_9)), @r"       0.000000   1\r\n");
    assert_snapshot!(line(angle(f64::INFINITY)), @r"       0.000000   0\r\n");
}

#[test]
fn a_recorded_line_is_read() {
    // From the parser tests of the ROS package `kvh`.
    let read = read(b"       0.015733   1\r\n", OutputMode::Rate);
    assert_eq!(read, [GyroOutput::Rate(AngularRate::from_deg_per_s(0.015_733))]);
}

#[test]
fn the_manuals_form_is_read() {
    let read = read(b"-001.500000 1\r\n090.000000 0\r\n", OutputMode::Increment);
    assert_eq!(read, [-1.5, 90.0].map(|deg| GyroOutput::Increment(Angle::from_deg(deg))));
}

#[test]
fn a_spacing_of_its_own_is_read_once_it_is_known() {
    let line = |k: u32| std::format!("{:11}  1\r\n", std::format!("-{k}.500000"));
    let right = |k: u32| std::format!("{:>11}  1\r\n", std::format!("-{k}.500000"));
    let text: String = (1..200).map(right).collect();
    let rates = |text: &str| -> Vec<f64> {
        let outputs = read(text.as_bytes(), OutputMode::Rate).into_iter();
        let rate = |output| match output {
            GyroOutput::Rate(rate) => rate.deg_per_s(),
            other => panic!("{other:?}"),
        };
        outputs.map(rate).collect()
    };
    assert_eq!(rates(&text).len(), 199 - super::FORM_LINES as usize + 1);
    // What loses a byte afterwards is refused, and so is the same where the usual lines stand between.
    let lost = right(123).replacen('2', "", 1);
    assert_eq!(rates(&(text.clone() + &lost)).len(), rates(&text).len());
    let usual = line_of(-123.5);
    let between: String = (0..50).map(|_| usual.clone() + &usual.replacen('2', "", 1)).collect();
    assert_eq!(rates(&between).len(), 50);
    // Numbers that begin in one column have no columns: a lost digit would not show.
    let ragged: String = (0..100).map(|k| line(if k % 2 == 0 { 5 } else { 15 })).collect();
    assert!(rates(&ragged).is_empty());
}

fn line_of(rate_deg_per_s: f64) -> String {
    String::from_utf8(encode(&rate_sample(rate_deg_per_s)).to_vec()).unwrap()
}

#[test]
fn lines_that_are_not_right_are_refused() {
    for text in [
        "\r\n",
        "      30.000000   1\n\n",
        "      30.000000   2\r\n",
        "      30.00000    1\r\n",
        "      30,000000   1\r\n",
        "       +0.00000   1\r\n",
        "    - 30.000000   1\r\n",
        "    1030.000000   1\r\n",
        "        .000000   1\r\n",
        "30.000000 1\r\n",
        "0030.000000 1\r\n",
        "030.000000  1\r\n",
        "     --.-------   1\r\n",
    ] {
        assert!(read(text.as_bytes(), OutputMode::Rate).is_empty(), "{text:?}");
    }
}

#[test]
fn a_lost_or_doubled_byte_is_caught() {
    let line = encode(&rate_sample(-123.456_789)).as_slice().to_vec();
    for at in 0..line.len() {
        let mut lost = line.clone();
        lost.remove(at);
        assert!(read(&lost, OutputMode::Rate).is_empty(), "lost {at}");
        let mut doubled = line.clone();
        doubled.insert(at, line[at]);
        // A second line feed is an empty line after a good one.
        let expected = usize::from(at == line.len() - 1);
        assert_eq!(read(&doubled, OutputMode::Rate).len(), expected, "doubled {at}");
    }
}

#[test]
fn an_angle_of_more_than_a_turn_is_refused() {
    let text = b"     360.000001   1\r\n     -90.000000   1\r\n";
    let read = read(text, OutputMode::Integrated);
    assert_eq!(read, [GyroOutput::Integrated(Angle::from_deg(-90.0))]);
}
