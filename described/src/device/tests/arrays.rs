//! Arrays, numbered signals, and look-up tables in operation.

use super::{at, listed, parse, run};
use crate::Description;
use crate::device::Device;
use std::sync::Arc;

const PACK: &str = r#"
name = "pack"
[parameter."capacity[1..12]"]
value = 2.5
minimum = 0.1
[parameter.amperes]
value = 3600
[table.ocv]
x = [0, 0.5, 1]
y = [3.0, 3.6, 4.2]
[state."soc[1..12]"]
start = "0.5 + i / 100"
rate = "amperes / (3600 * capacity[i])"
[state."cell[1..12]"]
value = "ocv(soc[i]) - if(i == 12, 0.5, 0)"
[state."peak[1..12]"]
value = "max(last(peak[i]), cell[i])"
[signal."CellVoltage[01..12]"]
expression = "cell[i]"
[signal.Highest]
expression = "max(cell)"
[signal.Weakest]
expression = "argmin(cell)"
[signal.Mean]
expression = "mean(cell) - (sum(cell) - min(cell) + 3.124) / 12"
[signal.Asked]
expression = "cell[Which]"
[[message]]
name = "Cells"
sent_by = "device"
can_id = 1
period_s = 1
fields = [
  { name = "CellVoltage01", type = "f32" },
  { name = "CellVoltage12", type = "f32" },
]
[[message]]
name = "Summary"
sent_by = "device"
can_id = 2
period_s = 1
fields = [{ name = "Highest", type = "f32" }, { name = "Weakest", type = "u8" }, { name = "Mean", type = "i16", scale = 0.001 }]
[[message]]
name = "Answer"
sent_by = "device"
can_id = 3
period_s = 1
fields = [{ name = "Asked", type = "f32" }]
[[message]]
name = "Ask"
sent_by = "host"
can_id = 4
initial = { Which = 3 }
fields = [{ name = "Which", type = "u8" }]
"#;

/// With a signal for each cell.
fn pack() -> Arc<Description> {
    let fields = |first: u32| {
        let field = |cell: u32| {
            format!("{{ name = \"CellVoltage{cell:02}\", type = \"u16\", scale = 0.001 }},")
        };
        (first..first + 3).map(field).collect::<String>()
    };
    let message = |number: u32| {
        format!(
            "[[message]]\nname = \"Cells{number}\"\nsent_by = \"device\"\ncan_id = {}\nperiod_s = 1\nfields = [{}]\n",
            16 + number,
            fields(3 * number + 1)
        )
    };
    let (before, behind) = PACK.split_once("[[message]]\nname = \"Cells\"").unwrap();
    let (_, behind) = behind.split_once("[[message]]").unwrap();
    parse(&format!("{before}{}[[message]]{behind}", (0..4).map(message).collect::<String>()))
}

#[test]
fn each_element_goes_its_own_way_and_shows_itself() {
    let description = pack();
    let mut device = Device::new(Arc::clone(&description), 1);
    let start: Vec<f64> = (1..=12).map(|i| device.value(&format!("soc{i}")).unwrap()).collect();
    assert_eq!((start[0], start[11]), (0.51, 0.62));
    assert!(device.set_parameter(at(0.0), "capacity", 1e9), "all of them");
    assert!(device.set_parameter(at(0.0), "capacity2", 5.0));
    assert!(!device.set_parameter(at(0.0), "capacity13", 5.0));
    assert!(!device.set_parameter(at(0.0), "capacity", 0.0));
    let sent = listed(description.layout(), &run(&mut device, 1.0));
    // The second one has charged by 0.2: 3.0 + 1.2 * (0.52 + 0.2).
    let expected = [
        "1 Cells0 [3.612, 3.864, 3.636]",
        "1 Cells1 [3.648, 3.66, 3.672]",
        "1 Cells2 [3.684, 3.696, 3.708]",
        "1 Cells3 [3.72, 3.732, 3.244]",
    ];
    for (found, expected) in sent.iter().zip(expected) {
        assert_eq!(found.replace("0000000000003", "").replace("0000000000001", ""), expected);
    }
    let near = |name: &str, expected: f64| {
        let found = device.value(name).unwrap();
        // The others charge a little too, over 1e9 Ah.
        assert!((found - expected).abs() < 1e-8, "{name}: {found}");
    };
    near("Highest", 3.864);
    near("Weakest", 12.0);
    near("Asked", 3.636);
    near("peak2", 3.864);
    near("Mean", (3.244 - 3.124) / 12.0);
    assert_eq!(device.not_finite(), 0);
}

#[test]
fn an_index_that_there_is_not_leaves_what_was_before() {
    let description = pack();
    let mut device = Device::new(Arc::clone(&description), 1);
    run(&mut device, 1.0);
    let ask = description.layout().find("Ask").unwrap();
    let Ok(wire::device::Transmit::Frame(frame)) = description.layout().encode(ask, &[13.0]) else {
        panic!("on CAN")
    };
    let before = device.value("Asked");
    device.receive_frame(at(1.5), &frame);
    run(&mut device, 2.0);
    assert_eq!(device.value("Asked"), before);
    assert_eq!(device.not_finite(), 1);
}

#[test]
fn tables_come_from_files_too() {
    let read = &mut |name: &str| match name {
        "ocv.csv" => Ok("soc,volts\n0,3\n1,4\n".to_owned()),
        "map.csv" => Ok("soc,0,10\n0,1,2\n1,3,8\n".to_owned()),
        other => Err(format!("no {other}")),
    };
    let text = "name = \"d\"\n[table.ocv]\ncsv = \"ocv.csv\"\noutside = \"extrapolate\"\n[table.map]\ncsv = \"map.csv\"\n\
                [table.inline]\nx = [0, 1]\ny = [0, 10]\nz = [[1, 2], [3, 8]]\n\
                [state.a]\nvalue = \"ocv(1.5)\"\n[state.b]\nvalue = \"map(0.5, 5) - inline(0.5, 5)\"\n\
                [state.c]\nvalue = \"map(2, 20)\"\n[signal.x]\nexpression = \"a\"\n\
                [[message]]\nname = \"M\"\nsent_by = \"device\"\ncan_id = 1\nperiod_s = 1\n\
                fields = [{ name = \"x\", type = \"f64\" }]\n";
    let description = Description::parse("d.toml", text, read).unwrap();
    let device = Device::new(Arc::new(description), 1);
    let found = ["a", "b", "c"].map(|name| device.value(name).unwrap());
    assert_eq!(found, [4.5, 0.0, 8.0]);
}
