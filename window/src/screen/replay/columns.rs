//! What a recording holds, column by column of the bar's pixels.

use bus::message::TimelineColumn;

use crate::model::ReplayModel;

/// What the top of the band of errors may mean, mm.
const TOPS_MM: [f32; 10] = [0.5, 1.0, 2.0, 5.0, 10.0, 20.0, 50.0, 100.0, 500.0, 1000.0];
/// So many columns in a hundred may reach beyond the top: one large error is not to flatten all others.
const BEYOND: usize = 5;

/// All that falls into each column of pixels; `None` where nothing was read.
pub(super) fn of(replay: &ReplayModel, count: usize) -> Vec<Option<TimelineColumn>> {
    let mut found: Vec<Option<TimelineColumn>> = vec![None; count.max(1)];
    let most = found.len() - 1;
    let [first, last] = replay.span_ns;
    for ([from_ns, to_ns], column) in replay.timeline.iter().flat_map(|timeline| timeline.columns()) {
        if to_ns <= first || from_ns > last || column.states == 0 {
            continue;
        }
        let at = |t_ns: i64| (replay.part(t_ns) * found.len() as f64).floor() as usize;
        let range = at(from_ns).min(most)..=at(to_ns.saturating_sub(1)).min(most);
        for room in &mut found[range] {
            let all = room.get_or_insert(TimelineColumn::EMPTY);
            all.states |= column.states;
            for mm in [column.least_mm, column.most_mm] {
                if !mm.is_nan() {
                    all.error(f64::from(mm));
                }
            }
        }
    }
    found
}

/// The least top beyond which no more than a few columns reach; `None` where no pose came with an error.
pub(super) fn top_mm(columns: &[Option<TimelineColumn>]) -> Option<f32> {
    let mut most: Vec<f32> = columns
        .iter()
        .flatten()
        .map(|column| column.most_mm)
        .filter(|mm| !mm.is_nan())
        .collect();
    most.sort_by(f32::total_cmp);
    let place = most.len().saturating_sub(1) - most.len() * BEYOND / 100;
    let enough = most.get(place).copied()?;
    let largest = TOPS_MM[TOPS_MM.len() - 1];
    Some(TOPS_MM.into_iter().find(|top| *top >= enough).unwrap_or(largest))
}

/// Neighbours that look alike, as one: where they begin, where they end, and the first of them.
pub(super) fn runs<K: PartialEq>(
    columns: &[Option<TimelineColumn>],
    key: impl Fn(Option<TimelineColumn>) -> K,
) -> impl Iterator<Item = (usize, usize, Option<TimelineColumn>)> {
    let mut begins = 0;
    std::iter::from_fn(move || {
        let first = *columns.get(begins)?;
        let length = columns[begins..]
            .iter()
            .take_while(|column| key(**column) == key(first))
            .count();
        let from = begins;
        begins += length;
        Some((from, begins, first))
    })
}
