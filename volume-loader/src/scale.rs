//! Which slopes and intercepts can turn stored numbers into HU.

/// From the lowest to the highest HU that is held.
const SPAN_HU: f64 = 65_535.0;

/// What cannot be used, and what it must be.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Unusable {
    Slope(&'static str),
    Intercept(&'static str),
}

/// Whether `HU = slope * stored + intercept` can tell tissues apart, for stored numbers from `range[0]` to `range[1]`.
///
/// # Errors
/// [`Unusable`]: where every number becomes the same HU, or all or all but one of them leave 16 bits. Some that leave them are
/// held to the nearest that does not, and counted ([`Conversion`](crate::source::Conversion)).
pub(crate) fn check([slope, intercept]: [f64; 2], [low, high]: [f64; 2]) -> Result<(), Unusable> {
    if !slope.is_normal() {
        return Err(Unusable::Slope("a finite number other than 0"));
    }
    if !intercept.is_finite() {
        return Err(Unusable::Intercept("a finite number"));
    }
    if slope.abs() > SPAN_HU {
        let expected = "at most 65535 either way: else no two stored numbers are both from -32768 to 32767 HU";
        return Err(Unusable::Slope(expected));
    }
    // Halves, as the difference of two doubles may be beyond the largest.
    if slope.abs() * (high / 2.0 - low / 2.0) < 0.5 {
        let expected = "so large that all stored numbers together span at least 1 HU";
        return Err(Unusable::Slope(expected));
    }
    let ends = [slope * low + intercept, slope * high + intercept];
    let beyond = |hu: f64| hu > f64::from(i16::MAX);
    let below = |hu: f64| hu < f64::from(i16::MIN);
    if ends.into_iter().all(beyond) || ends.into_iter().all(below) {
        return Err(Unusable::Intercept(
            "so that some stored number is from -32768 to 32767 HU",
        ));
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    const BITS_12: [f64; 2] = [0.0, 4095.0];

    #[test]
    fn what_no_scanner_means_is_refused() {
        let slope = |slope: f64| matches!(check([slope, -1024.0], BITS_12), Err(Unusable::Slope(_)));
        for bad in [0.0, -0.0, 1e38, -1e38, 1e-310, 1e-5, 65_536.0, f64::NAN, f64::INFINITY] {
            assert!(slope(bad), "{bad}");
        }
        for good in [1.0, -1.0, 0.5, 1e-3, 100.0, 65_535.0] {
            assert!(!slope(good), "{good}");
        }
        let intercept = |intercept: f64| matches!(check([1.0, intercept], BITS_12), Err(Unusable::Intercept(_)));
        for bad in [1e38, -1e38, 32_768.0, -36_864.0, f64::NAN, f64::NEG_INFINITY] {
            assert!(intercept(bad), "{bad}");
        }
        for good in [0.0, -1024.0, -8192.0, 32_767.0, -36_863.0] {
            assert!(!intercept(good), "{good}");
        }
    }

    #[test]
    fn reals_have_any_range() {
        let any = [-f64::MAX, f64::MAX];
        assert_eq!(check([1e-6, 0.0], any), Ok(()));
        assert_eq!(check([1.0, -1024.0], any), Ok(()));
        assert!(check([1e38, 0.0], any).is_err() && check([f64::MIN_POSITIVE / 4.0, 0.0], any).is_err());
    }
}
