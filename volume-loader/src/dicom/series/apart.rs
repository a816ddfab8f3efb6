//! Slices of one series that are listed apart, for another orientation, spacing, size or modality: who chooses one list is without the
//! others, and where these lie at an end no gap shows it.

use std::collections::BTreeMap;

use crate::dicom::header::Header;

/// The study and the series.
type Of<'a> = (&'a str, &'a str);

/// For each of these groups, a sentence where others have slices of its series. Localizers are none, and frames are told of by
/// [`Whole`](super::whole::Whole).
pub(super) fn told(groups: &[(Vec<Header>, bool)]) -> Vec<Option<String>> {
    let mut slices: BTreeMap<Of<'_>, usize> = BTreeMap::new();
    for (headers, _) in groups {
        if let Some(series) = series(headers) {
            *slices.entry(series).or_default() += headers.len();
        }
    }
    let others = groups.iter().map(|(headers, _)| {
        let all = slices.get(&series(headers)?)?;
        Some(all - headers.len()).filter(|others| *others > 0)
    });
    let words = |others: usize| {
        format!(
            "{others} more slices of this series (SeriesInstanceUID) are listed apart, for another orientation, spacing, size or modality: \
             they are not in this volume"
        )
    };
    others.map(|others| others.map(words)).collect()
}

fn series(headers: &[Header]) -> Option<Of<'_>> {
    let first = headers
        .first()
        .filter(|first| first.frame.is_none() && !first.localizer)?;
    Some((first.study.as_str(), first.series.as_deref()?))
}
