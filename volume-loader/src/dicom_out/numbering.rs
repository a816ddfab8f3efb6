//! File names and instance numbers.

use chance::SplitMix64;

/// The names and numbers of a series' files.
#[derive(Debug)]
pub(super) struct Numbering {
    names: Vec<u32>,
    instances: Vec<u32>,
}

impl Numbering {
    /// Of `count` slices: in order, or in two random orders of `seed`.
    pub(super) fn new(count: u32, seed: Option<u64>) -> Self {
        let order: Vec<u32> = (1..=count).collect();
        let (mut names, mut instances) = (order.clone(), order);
        if let Some(seed) = seed {
            let mut random = SplitMix64::new(seed);
            shuffle(&mut names, &mut random);
            shuffle(&mut instances, &mut random);
        }
        Self { names, instances }
    }

    /// The file of slice `k`.
    pub(super) fn file_name(&self, k: u32) -> String {
        let number = self.names.get(k as usize).copied().unwrap_or(k + 1);
        let digits = self.names.len().to_string().len().max(4);
        format!("IM{number:0digits$}.dcm")
    }

    /// The instance number of slice `k`, from 1.
    pub(super) fn instance(&self, k: u32) -> u32 {
        self.instances.get(k as usize).copied().unwrap_or(k + 1)
    }
}

/// Fisher and Yates; the modulus favours none by more than 2^-50.
fn shuffle(numbers: &mut [u32], random: &mut SplitMix64) {
    for i in (1..numbers.len()).rev() {
        numbers.swap(i, (random.bits() % (i as u64 + 1)) as usize);
    }
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;

    use super::*;

    #[test]
    fn in_order_unless_shuffled() {
        let plain = Numbering::new(3, None);
        assert_eq!((plain.file_name(0).as_str(), plain.instance(2)), ("IM0001.dcm", 3));
        assert_eq!(Numbering::new(16_384, None).file_name(0), "IM00001.dcm");
    }

    #[test]
    fn shuffled_numbers_are_all_there_and_the_two_orders_differ() {
        let shuffled = Numbering::new(100, Some(5));
        let names: BTreeSet<_> = (0..100).map(|k| shuffled.file_name(k)).collect();
        let instances: Vec<u32> = (0..100).map(|k| shuffled.instance(k)).collect();
        assert_eq!(
            (names.len(), instances.iter().collect::<BTreeSet<_>>().len()),
            (100, 100)
        );
        assert!(
            !instances.is_sorted()
                && (0..100).any(|k| shuffled.file_name(k) != format!("IM{:04}.dcm", shuffled.instance(k)))
        );
        let other = Numbering::new(100, Some(6));
        assert!((0..100).any(|k| shuffled.instance(k) != other.instance(k)));
    }
}
