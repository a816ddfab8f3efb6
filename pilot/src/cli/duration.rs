//! Durations as people type them.

use std::time::Duration;

/// `500ms`, `10s`, `2m` or `1h`.
pub(crate) fn parse(text: &str) -> Result<Duration, String> {
    let allowed = || format!("{text:?}: a duration is a number and a unit: 500ms, 10s, 2m, 1h");
    let split = text.find(|c: char| c.is_ascii_alphabetic()).ok_or_else(allowed)?;
    let number: f64 = text[..split].parse().map_err(|_| allowed())?;
    let unit = match &text[split..] {
        "ms" => 1e-3,
        "s" => 1.0,
        "m" => 60.0,
        "h" => 3600.0,
        _ => return Err(allowed()),
    };
    let seconds = number * unit;
    if !(0.1..=86_400.0).contains(&seconds) {
        return Err(format!("{text:?}: allowed are 100ms to 24h"));
    }
    Ok(Duration::from_secs_f64(seconds))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn units_and_refusals() {
        assert_eq!(parse("10s"), Ok(Duration::from_secs(10)));
        assert_eq!(parse("1.5m"), Ok(Duration::from_secs(90)));
        assert_eq!(parse("500ms"), Ok(Duration::from_millis(500)));
        for bad in ["", "10", "s", "-3s", "nans", "1e9s", "3 weeks"] {
            assert!(parse(bad).is_err(), "{bad}");
        }
    }
}
