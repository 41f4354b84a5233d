//! Answers that nobody awaits: a controller answers each mission once.

use controller::mission::MissionId;

/// Number of the first mission; the others follow in the order of their records.
pub const FIRST_MISSION: MissionId = 1;

/// Most notes about them; the answers themselves are in the record.
const NOTES_MAX: u32 = 20;

#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub(super) struct Strays {
    count: u32,
    last: Option<String>,
}

impl Strays {
    /// Takes an answer to mission `id`, where `next_id` has not been given yet. Returns a note, up to the limit.
    pub(super) fn take(&mut self, id: MissionId, next_id: MissionId) -> Option<String> {
        let given = (FIRST_MISSION..next_id).contains(&id);
        let how = if given { "once more" } else { "which was not given" };
        let what = format!("the controller answered mission {id}, {how}");
        self.last = Some(what.clone());
        self.count = self.count.saturating_add(1);
        (self.count <= NOTES_MAX).then_some(what)
    }

    /// The last of them, as the end of a sentence about an answer that did not come.
    pub(super) fn instead(&self) -> String {
        self.last.as_ref().map_or_else(String::new, |what| format!("; {what}"))
    }
}

#[cfg(test)]
mod tests {
    use super::{NOTES_MAX, Strays};

    #[test]
    fn an_answer_to_no_mission_is_told_from_a_second_one_and_notes_end() {
        let mut strays = Strays::default();
        assert_eq!(strays.instead(), "");
        assert_eq!(strays.take(3, 4).unwrap(), "the controller answered mission 3, once more");
        let unknown = strays.take(4, 4).unwrap();
        assert_eq!(unknown, "the controller answered mission 4, which was not given");
        assert_eq!(strays.instead(), format!("; {unknown}"));
        let noted = (0..NOTES_MAX).filter(|_| strays.take(0, 4).is_some()).count();
        assert_eq!(noted, NOTES_MAX as usize - 2);
    }
}
