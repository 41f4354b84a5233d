//! Values that a device could not send, because the range of their signal or object ends before them.

/// A signal or an object with values beyond its range.
#[derive(Debug, Clone)]
pub struct Clipped<'a> {
    /// `message.signal`, or the name of the object.
    pub name: String,
    /// Its smallest and its largest value.
    pub range: (f64, f64),
    /// Unit of its values; may be empty.
    pub unit: &'a str,
    /// Number of values that became the nearer end of the range.
    pub count: u64,
    /// The value farthest from the range.
    pub farthest: f64,
}

/// The counts of one message, or of a device's objects: only those with such values.
#[derive(Debug, Clone, Default)]
pub(crate) struct Counts(Vec<Count>);

#[derive(Debug, Clone)]
struct Count {
    place: usize,
    count: u64,
    farthest: f64,
    /// Distance of the farthest value from the range.
    excess: f64,
}

impl Counts {
    /// Counts a `value` of what is at this place that is sent as `inside`.
    #[cold]
    pub(crate) fn add(&mut self, place: usize, value: f64, inside: f64) {
        let excess = (value - inside).abs();
        match self.0.iter_mut().find(|known| known.place == place) {
            None => self.0.push(Count { place, count: 1, farthest: value, excess }),
            Some(known) => {
                known.count += 1;
                if excess > known.excess {
                    (known.farthest, known.excess) = (value, excess);
                }
            }
        }
    }

    /// The place, the count and the farthest value of each, in the order of places.
    pub(crate) fn all(&self) -> Vec<(usize, u64, f64)> {
        let all = self.0.iter().map(|known| (known.place, known.count, known.farthest));
        let mut all: Vec<_> = all.collect();
        all.sort_unstable_by_key(|(place, ..)| *place);
        all
    }
}
