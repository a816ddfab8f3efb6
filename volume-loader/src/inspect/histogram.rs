//! How often which HU is there, as numbers and as a sketch of characters.

use serde::Serialize;

/// The first bin's lower end: -1024 HU.
const LOW_HU: i16 = -1024;
/// The width of a bin, HU.
const WIDTH_HU: i16 = 40;
/// How many bins: up to 1536 HU, dense bone.
const BINS: usize = 64;
/// Lines of the sketch.
const LINES: usize = 8;
const BLOCKS: [char; 9] = [' ', '▁', '▂', '▃', '▄', '▅', '▆', '▇', '█'];
/// What lies where, HU: the middle of the tissue's usual range.
const TISSUES: [(&str, i16); 5] = [
    ("air", -1000),
    ("lung", -700),
    ("fat", -100),
    ("soft", 40),
    ("bone", 700),
];

/// Voxels in bins of equal width; the same bins for every volume, so that two can be compared.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct Histogram {
    /// The lower end of the first bin, HU.
    pub low_hu: i16,
    /// The width of each bin, HU.
    pub width_hu: i16,
    /// Voxels below the first bin.
    pub below: u64,
    /// Voxels in each bin; each holds its lower end and not its upper one.
    pub bins: Vec<u64>,
    /// Voxels above the last bin.
    pub above: u64,
}

impl Histogram {
    /// Of pairs of HU and the number of voxels that hold it.
    pub(super) fn of(counts: impl Iterator<Item = (i16, u64)>) -> Self {
        let mut histogram = Self {
            low_hu: LOW_HU,
            width_hu: WIDTH_HU,
            below: 0,
            bins: vec![0; BINS],
            above: 0,
        };
        for (hu, count) in counts {
            let bin = (i32::from(hu) - i32::from(LOW_HU)).div_euclid(i32::from(WIDTH_HU));
            let place = match usize::try_from(bin) {
                Err(_) => &mut histogram.below,
                Ok(bin) => histogram.bins.get_mut(bin).unwrap_or(&mut histogram.above),
            };
            *place += count;
        }
        histogram
    }

    /// Lines for a terminal, a column per bin, heights as logarithms, and under them what lies where.
    pub(super) fn sketch(&self) -> Vec<String> {
        let height = |count: u64| (count as f64).ln_1p();
        let full = self
            .bins
            .iter()
            .copied()
            .max()
            .map_or(0.0, height)
            .max(f64::MIN_POSITIVE);
        let levels = (LINES * (BLOCKS.len() - 1)) as f64;
        let filled: Vec<usize> = self
            .bins
            .iter()
            .map(|&count| (height(count) / full * levels).ceil() as usize)
            .collect();
        let line = |line: usize| -> String {
            let under = line * (BLOCKS.len() - 1);
            filled
                .iter()
                .map(|level| BLOCKS[level.saturating_sub(under).min(BLOCKS.len() - 1)])
                .collect()
        };
        let mut lines: Vec<String> = (0..LINES).rev().map(line).collect();
        lines.push(axis("┴", "─", |hu| hu % 200 == 0));
        lines.push(labels(&TISSUES.map(|(name, hu)| (name.to_owned(), hu))));
        lines.push(labels(
            &[LOW_HU, -600, -200, 0, 400, 1000].map(|hu| (hu.to_string(), hu)),
        ));
        lines
    }
}

/// The column of a HU.
fn column(hu: i16) -> usize {
    let bin = (i32::from(hu) - i32::from(LOW_HU)) / i32::from(WIDTH_HU);
    usize::try_from(bin).unwrap_or_default()
}

/// A line with a tick in each column that holds one of the HU where `is_tick`.
fn axis(tick: &str, plain: &str, is_tick: impl Fn(i16) -> bool) -> String {
    let holds = |bin: usize| {
        let low = LOW_HU + bin as i16 * WIDTH_HU;
        (low..low + WIDTH_HU).any(&is_tick)
    };
    (0..BINS).map(|bin| if holds(bin) { tick } else { plain }).collect()
}

/// Words with their middles in the columns of their HU, ascending, and at least a space between them.
fn labels(words: &[(String, i16)]) -> String {
    words.iter().fold(String::new(), |mut line, (word, hu)| {
        let start = column(*hu).saturating_sub(word.len() / 2);
        let gap = start.saturating_sub(line.len()).max(usize::from(!line.is_empty()));
        line.extend(std::iter::repeat_n(' ', gap));
        line + word
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bins_hold_their_lower_end() {
        let counts = [
            (-1025, 1),
            (-1024, 2),
            (-985, 4),
            (-984, 8),
            (1535, 16),
            (1536, 32),
            (i16::MAX, 64),
        ];
        let histogram = Histogram::of(counts.into_iter());
        assert_eq!((histogram.below, histogram.above), (1, 96));
        assert_eq!((histogram.bins[0], histogram.bins[1], histogram.bins[63]), (6, 8, 16));
    }

    #[test]
    fn a_sketch_has_its_peaks_over_their_names() {
        let lines = Histogram::of([(-1000, 1000), (40, 1000), (700, 1)].into_iter()).sketch();
        assert_eq!(lines.len(), LINES + 3);
        let at = |line: &str, column: usize| line.chars().nth(column).unwrap();
        assert!(at(&lines[0], column(-1000)) == '█' && at(&lines[0], column(40)) == '█');
        assert_eq!((at(&lines[0], column(700)), at(&lines[7], column(700))), (' ', '▇'));
        assert_eq!(lines[9].find("bone"), Some(column(700) - 2));
        assert_eq!(lines[8].chars().count(), BINS);
        let empty = Histogram::of(std::iter::empty()).sketch();
        assert!(empty[..LINES].iter().all(|line| line.trim().is_empty()));
    }
}
