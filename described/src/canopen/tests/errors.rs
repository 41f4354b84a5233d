//! What a device says of errors, and of values and messages that cannot be.

use super::{Bus, DRIVE, EDS, at_ms, described};
use crate::canopen::{Abort, Progress, SdoClient};
use std::sync::Arc;

/// Of two conditions with one code, one holds.
#[test]
fn an_error_that_two_conditions_raise_is_said_once() {
    let toml =
        format!("{DRIVE}\n[emergency.again]\nwhen = \"motor_temperature > 500\"\ncode = 0x4310\n")
            .replace("value = 40\n", "value = 130\n");
    let mut bus = Bus::of(Arc::new(described(&toml, EDS).unwrap()));
    let said = bus.until(at_ms(500)).into_iter().filter(|(_, id, _)| *id == 0x85);
    assert_eq!(said.count(), 1);
}

#[test]
fn a_pdo_without_objects_is_not_sent() {
    let mut bus = Bus::new();
    bus.say(0, &[1, 5]);
    let of_first =
        |sent: Vec<(i64, u16, Vec<u8>)>| sent.into_iter().filter(|(_, id, _)| *id == 0x185).count();
    assert!(of_first(bus.until(at_ms(1000))) > 0);
    // Switched off, emptied, and switched on again.
    let cob = bus.transfer((0x1800, 1), None).unwrap();
    let off = u32::from_le_bytes(*cob.first_chunk().unwrap()) | 1 << 31;
    bus.write((0x1800, 1), &off.to_le_bytes()).unwrap();
    bus.write((0x1A00, 0), &[0]).unwrap();
    bus.write((0x1800, 1), &cob).unwrap();
    assert_eq!(of_first(bus.until(at_ms(3000))), 0);
}

#[test]
fn what_the_history_of_errors_does_not_hold_cannot_be_read() {
    let toml = DRIVE.replace("value = 40\n", "value = 130\n");
    let mut bus = Bus::of(Arc::new(described(&toml, EDS).unwrap()));
    bus.until(at_ms(100));
    assert_eq!(bus.transfer((0x1003, 1), None).unwrap()[..2], [0x10, 0x43]);
    bus.write((0x1003, 0), &[0]).unwrap();
    assert_eq!(bus.transfer((0x1003, 1), None), Err(Abort(0x0800_0024)));
}

#[test]
fn an_object_with_the_name_of_a_function_is_called_by_its_index() {
    let least = "[2001]\nParameterName=Min\nDataType=7\nAccessType=rw\n";
    let found = described(DRIVE, &format!("{EDS}\n{least}")).unwrap();
    let dictionary = found.layout().dictionary().unwrap();
    assert_eq!(dictionary.find(0x2001, 0).unwrap().name(), "min_2001sub0");
}

#[test]
fn a_lost_heartbeat_is_forgotten_with_the_order_to_await_it() {
    let mut bus = Bus::new();
    bus.write((0x1016, 1), &0x0007_0064u32.to_le_bytes()).unwrap();
    bus.say(0x707, &[5]);
    let lost = bus.until(at_ms(500));
    assert!(lost.iter().any(|(_, id, data)| *id == 0x85 && data[..2] == [0x30, 0x81]), "{lost:?}");
    bus.write((0x1016, 1), &[0; 4]).unwrap();
    assert_eq!(bus.transfer((0x1001, 0), None).unwrap(), [0]);
}

#[test]
fn an_abort_of_another_object_is_no_answer() {
    let (mut client, _) = SdoClient::new(at_ms(0), (0x2000, 0), None);
    let abort = |index: u16| {
        let [low, high] = index.to_le_bytes();
        [0x80, low, high, 0, 0, 0, 2, 6]
    };
    assert_eq!(client.receive(at_ms(1), &abort(0x2001)), Progress::Nothing);
    assert_eq!(client.other(), Some((0x2001, 0)));
    let aborted = Progress::Aborted(Abort(0x0602_0000));
    assert_eq!(client.receive(at_ms(1), &abort(0x2000)), aborted);
}

#[test]
fn values_that_an_object_cannot_have_are_counted() {
    let of = |expression: &str| {
        let toml =
            DRIVE.replace("expression = \"velocity\"", &format!("expression = \"{expression}\""));
        let mut bus = Bus::of(Arc::new(described(&toml, EDS).unwrap()));
        for _ in 0..3 {
            bus.transfer((0x606C, 0), None).unwrap();
        }
        let clipped = bus.device.clipped().map(|one| (one.name, one.count));
        (clipped.collect::<Vec<_>>(), bus.device.not_finite())
    };
    assert_eq!(of("1e9"), (vec![("velocity_actual_value".to_owned(), 3)], 0));
    assert_eq!(of("0 * velocity / 0"), (Vec::new(), 3));
    assert_eq!(of("velocity"), (Vec::new(), 0));
}
