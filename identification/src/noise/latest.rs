//! The latest filters of poses: causes that are compared have most noises in common.

use super::NoiseModel;
use super::pose_filter::PoseFilter;
use std::cell::RefCell;
use std::rc::Rc;

/// The latest filters by noise and outliers, latest first.
#[derive(Debug, Default)]
pub(super) struct Latest(RefCell<Vec<Known>>);

type Known = (NoiseModel, Vec<bool>, Rc<PoseFilter>);

/// Number of filters that are kept.
const KEPT: usize = 24;

impl Latest {
    /// The filter for this noise and these outliers, from `new` if it is not known.
    pub fn filter(
        &self,
        noise: &NoiseModel,
        left_out: &[bool],
        new: impl FnOnce() -> PoseFilter,
    ) -> Rc<PoseFilter> {
        let mut known = self.0.borrow_mut();
        if let Some(index) = known.iter().position(|one| one.0 == *noise && one.1 == left_out) {
            known[..=index].rotate_right(1);
        } else {
            known.truncate(KEPT - 1);
            known.insert(0, (noise.clone(), left_out.to_vec(), Rc::new(new())));
        }
        Rc::clone(&known[0].2)
    }
}

#[cfg(test)]
mod tests {
    use super::{KEPT, Latest, NoiseModel, PoseFilter};

    #[test]
    fn what_was_asked_for_lately_is_not_made_again() {
        let latest = Latest::default();
        let is_made = |walk: usize, left_out: &[bool]| {
            let mut made = false;
            let noise = NoiseModel { walk: walk as f64, ..NoiseModel::white(1) };
            latest.filter(&noise, left_out, || {
                made = true;
                PoseFilter::default()
            });
            made
        };
        assert!(is_made(0, &[]) && is_made(0, &[true, false, false]));
        assert!(!is_made(0, &[]) && !is_made(0, &[true, false, false]));
        assert!((1..KEPT).all(|walk| is_made(walk, &[])));
        assert!(!is_made(0, &[true, false, false]) && is_made(0, &[]));
    }
}
