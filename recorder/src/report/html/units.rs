//! Times and lengths as a person reads them, with their units.

/// A moment of the run: `mm:ss`, with hours where there are any, and tenths of a second. Before the epoch with a minus.
pub(super) fn moment(t_ns: i64) -> String {
    let tenths = (t_ns.unsigned_abs() + 50_000_000) / 100_000_000;
    let sign = if t_ns < 0 && tenths > 0 { "-" } else { "" };
    let (seconds, tenth) = (tenths / 10, tenths % 10);
    format!("{sign}{}.{tenth}", whole(seconds))
}

/// Whole seconds as `mm:ss` or `h:mm:ss`.
pub(super) fn whole(seconds: u64) -> String {
    let (h, m, s) = (seconds / 3600, seconds / 60 % 60, seconds % 60);
    match h {
        0 => format!("{m:02}:{s:02}"),
        _ => format!("{h}:{m:02}:{s:02}"),
    }
}

/// A length of time: ms below a second, seconds below two minutes, beyond that `mm:ss` with its unit.
pub(super) fn length(ns: u64) -> String {
    match ns {
        0 => "0 s".to_owned(),
        1..1_000_000_000 => format!("{:.1} ms", ns as f64 / 1e6),
        1_000_000_000..120_000_000_000 => format!("{:.2} s", ns as f64 / 1e9),
        3_600_000_000_000.. => format!("{} h:min:s", whole(ns / 1_000_000_000)),
        _ => format!("{} min:s", whole(ns / 1_000_000_000)),
    }
}

/// Three digits that count, or as many as stand before the point.
pub(super) fn number(value: f64) -> String {
    match value.abs() {
        size if size >= 100.0 => format!("{value:.0}"),
        size if size >= 10.0 => format!("{value:.1}"),
        size if size >= 1.0 => format!("{value:.2}"),
        0.0 => "0".to_owned(),
        size if size >= 0.0005 => format!("{value:.3}"),
        _ => format!("{value:.1e}"),
    }
}

/// A round number beside an axis, without zeros that say nothing.
pub(super) fn plain(value: f64) -> String {
    let text = format!("{value:.6}");
    let text = text.trim_end_matches('0').trim_end_matches('.');
    match value.abs() {
        size if size > 0.0 && !(1e-6..1e7).contains(&size) => format!("{value:.0e}"),
        _ => text.to_owned(),
    }
}

/// A place in the examination.
pub(super) fn place([x, y, z]: [f64; 3]) -> String {
    format!("{x:.1}, {y:.1}, {z:.1}")
}

/// Bytes, with a unit of thousands.
pub(super) fn bytes(bytes: u64) -> String {
    match bytes {
        0..10_000 => format!("{bytes} bytes"),
        10_000..10_000_000 => format!("{:.1} kB", bytes as f64 / 1e3),
        10_000_000..10_000_000_000 => format!("{:.1} MB", bytes as f64 / 1e6),
        _ => format!("{:.1} GB", bytes as f64 / 1e9),
    }
}

/// A time of the wall clock, ns since 1970, in UTC.
pub(super) fn wall(ns: u64) -> String {
    let seconds = (ns / 1_000_000_000).cast_signed();
    let text = prost_types::Timestamp { seconds, nanos: 0 }.to_string();
    text.replace('T', " ").replace('Z', " UTC")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn times_are_minutes_and_seconds() {
        const S: i64 = 1_000_000_000;
        let cases = [
            (0, "00:00.0"),
            (61 * S, "01:01.0"),
            (S - 1, "00:01.0"),
            (-S, "-00:01.0"),
            (3_661 * S + S / 4, "1:01:01.3"),
        ];
        for (t_ns, words) in cases {
            assert_eq!(moment(t_ns), words);
        }
        assert_eq!(moment(i64::MIN).chars().next(), Some('-'));
        let lengths = [
            (0, "0 s"),
            (1_500_000, "1.5 ms"),
            (90 * 1_000_000_000, "90.00 s"),
            (150 * 1_000_000_000, "02:30 min:s"),
        ];
        for (ns, words) in lengths {
            assert_eq!(length(ns), words);
        }
        assert_eq!(wall(1_700_000_000_123_456_789), "2023-11-14 22:13:20 UTC");
        assert!(!wall(u64::MAX).is_empty());
    }

    #[test]
    fn numbers_keep_what_counts() {
        for (value, words) in [
            (0.0, "0"),
            (0.1234, "0.123"),
            (12.34, "12.3"),
            (1234.5, "1234"),
            (0.00001, "1.0e-5"),
        ] {
            assert_eq!(number(value), words);
        }
        for (value, words) in [
            (0.0, "0"),
            (0.1 + 0.2, "0.3"),
            (200.0, "200"),
            (0.01, "0.01"),
            (1e9, "1e9"),
        ] {
            assert_eq!(plain(value), words);
        }
    }
}
