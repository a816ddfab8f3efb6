//! How far a search goes at once: by parts that are halved where one fails, down to a least one, and grow again.

/// Parts found one after the other before they are doubled.
// After one alone every other search would fail where the way is hard.
const BEFORE_GROWTH: usize = 2;

/// Lengths of the parts of a way, mm.
#[derive(Debug, Clone, Copy)]
pub(super) struct Parts {
    part: f64,
    least: f64,
    most: f64,
    /// Found since the length was changed.
    found: usize,
}

impl Parts {
    /// Parts of the most at first, none shorter than the least.
    pub(super) fn new(least: f64, most: f64) -> Self {
        Self {
            part: most,
            least,
            most,
            found: 0,
        }
    }

    /// The shortest.
    pub(super) fn least(&self) -> f64 {
        self.least
    }

    /// Where the next part ends on the way to `end`: there to the bit, where hardly more than a part is left.
    pub(super) fn next(&self, done: f64, end: f64) -> f64 {
        if done + 1.001 * self.part >= end {
            end
        } else {
            done + self.part
        }
    }

    /// A part was found.
    pub(super) fn found(&mut self) {
        self.found += 1;
        if self.found == BEFORE_GROWTH {
            (self.part, self.found) = (self.most.min(2.0 * self.part), 0);
        }
    }

    /// A part of such a length was not found; false where half of it would be shorter than the least.
    pub(super) fn failed(&mut self, length: f64) -> bool {
        (self.part, self.found) = (0.5 * length, 0);
        self.part >= self.least
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A way of 4 in which nothing longer than `most(done)` is found: lengths of what was tried, and whether the end was reached.
    fn walked(most: impl Fn(f64) -> f64) -> (Vec<f64>, f64) {
        let (mut parts, mut done, mut tried) = (Parts::new(1.0 / 32.0, 2.0), 0.0, Vec::new());
        for end in [2.0, 4.0] {
            while done < end {
                let next = parts.next(done, end);
                tried.push(next - done);
                if next - done <= most(done) {
                    done = next;
                    parts.found();
                } else if !parts.failed(next - done) {
                    return (tried, done);
                }
            }
        }
        (tried, done)
    }

    /// A hard place in the middle of a long step once used up all halvings of the step, and parts did not grow behind it.
    #[test]
    fn parts_are_halved_at_a_hard_place_and_grow_behind_it() {
        let hard = |done: f64| if (1.0..1.2).contains(&done) { 0.04 } else { 1.0 };
        let (tried, done) = walked(hard);
        assert_eq!(done, 4.0);
        assert!(tried.iter().any(|t| *t < 0.04), "{tried:?}");
        assert_eq!(tried.iter().copied().fold(0.0, f64::max), 2.0);
        // 0.2 by a 32nd, and doubled up to 1 again.
        assert!(*tried.last().unwrap() >= 0.5 && tried.len() < 40, "{tried:?}");
    }

    #[test]
    fn what_no_part_leads_past_ends_the_way_there() {
        let (tried, done) = walked(|done| if done < 1.75 { 0.25 } else { 0.0 });
        assert_eq!(done, 1.75);
        // 1/4, 1/8, 1/16, 1/32, of which the last is the least: no shorter one is tried.
        assert_eq!(tried.last(), Some(&(1.0 / 32.0)));
        assert!(tried.len() < 20, "{tried:?}");
    }
}
