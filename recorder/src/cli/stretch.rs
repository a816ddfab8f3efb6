//! Moments of a recording as people type them.

/// `3.2s`, `250ms`, `2m` or plain seconds, as ns since the run's epoch.
pub(crate) fn moment(text: &str) -> Result<u64, String> {
    let allowed = || format!("{text:?}: a moment is a number of seconds, or one with a unit: 3.2, 3.2s, 250ms, 2m, 1h");
    let split = text.find(|c: char| c.is_ascii_alphabetic()).unwrap_or(text.len());
    let number: f64 = text[..split].parse().map_err(|_| allowed())?;
    let unit = match &text[split..] {
        "ms" => 1e-3,
        "" | "s" => 1.0,
        "m" => 60.0,
        "h" => 3600.0,
        _ => return Err(allowed()),
    };
    let seconds = number * unit;
    if !(0.0..=1e9).contains(&seconds) {
        return Err(allowed());
    }
    // At most 1e18.
    Ok((seconds * 1e9).round() as u64)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn units_and_refusals() {
        for (text, ns) in [
            ("3.2s", 3_200_000_000),
            ("3.2", 3_200_000_000),
            ("250ms", 250_000_000),
            ("2m", 120_000_000_000),
            ("0", 0),
        ] {
            assert_eq!(moment(text), Ok(ns), "{text}");
        }
        for bad in ["", "s", "-1s", "nan", "inf", "3 weeks", "1e10s"] {
            assert!(moment(bad).is_err(), "{bad}");
        }
    }
}
