//! Definitions of the common messages of ROS 2, for bags that have none.

use std::rc::Rc;

const COMMON: &str = include_str!("standard.msg");

/// The definition of `name` (`package/msg/Type`) with those that it uses, if it is a common message.
pub(super) fn definition(name: &str) -> Option<Rc<str>> {
    let plain = name.replacen("/msg/", "/", 1);
    let head = COMMON.lines().filter_map(|line| line.strip_prefix("MSG: "));
    let is_common = head.into_iter().any(|common| common == plain);
    let between = format!("{}\nMSG: ", "=".repeat(80));
    is_common.then(|| COMMON.replace("MSG: ", &between).into())
}

pub(super) fn unknown(name: &str) -> String {
    let packages = "std_msgs, geometry_msgs, sensor_msgs, nav_msgs and tf2_msgs";
    format!(
        "the bag has no definition of {name}, and hil knows only those of {packages}; \
         `ros2 bag convert` to MCAP adds it"
    )
}

#[cfg(test)]
mod tests {
    use super::super::definition::Definition;
    use super::{COMMON, definition};

    #[test]
    fn every_common_message_is_complete() {
        let names = COMMON.lines().filter_map(|line| line.strip_prefix("MSG: "));
        let mut count = 0;
        for name in names {
            let text = definition(&name.replace('/', "/msg/")).unwrap();
            let parsed =
                Definition::parse(name, &text, true).unwrap_or_else(|why| panic!("{name}: {why}"));
            assert!(parsed.message(parsed.root()).bytes_min > 0, "{name}");
            count += 1;
        }
        assert_eq!(count, 93);
        assert_eq!(definition("sensor_msgs/msg/Im"), None);
    }
}
