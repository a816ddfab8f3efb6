//! Rows that benchmarks have measured (`benches/shared/trade.rs` writes them): read, and refused where one is missing or is no number.

use super::dials::Dial;

/// The columns.
pub(super) const HEADER: &str = "dial,setting,chosen,time,time_unit,ratio,error,error_unit,against";

/// A setting of a dial.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Setting {
    pub(super) name: String,
    /// Whether the others' times are over this one's.
    pub(super) is_chosen: bool,
    pub(super) time: f64,
    pub(super) ratio: f64,
    pub(super) error: f64,
}

/// A dial with all that was measured of it.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Measured {
    pub(super) dial: &'static Dial,
    pub(super) time_unit: String,
    pub(super) error_unit: String,
    pub(super) against: String,
    /// In the order of the benchmark.
    pub(super) settings: Vec<Setting>,
}

impl Measured {
    /// All `dials`, in their order.
    ///
    /// # Errors
    /// In words: another header, a line that is none, a dial that nobody knows, that has fewer than three settings or not one chosen, a
    /// setting that stands twice, a time or an error that is not above zero, a ratio that is not that of the times.
    pub(super) fn parse(text: &str, dials: &'static [Dial]) -> Result<Vec<Self>, String> {
        let mut lines = text.lines();
        if lines.next() != Some(HEADER) {
            return Err(format!("the first line is not {HEADER:?}"));
        }
        let lines: Vec<[&str; 9]> = lines.map(fields).collect::<Result<_, _>>()?;
        if let Some(unknown) = lines.iter().find(|f| dials.iter().all(|d| d.name != f[0])) {
            return Err(format!("there is no dial {:?} in xtask/src/trade/dials.rs", unknown[0]));
        }
        let measured = dials.iter().map(|dial| {
            let own: Vec<&[&str; 9]> = lines.iter().filter(|f| f[0] == dial.name).collect();
            Self::of(dial, &own).map_err(|why| format!("dial {}: {why}", dial.name))
        });
        measured.collect()
    }

    fn of(dial: &'static Dial, lines: &[&[&str; 9]]) -> Result<Self, String> {
        let [first, _, _, ..] = lines else {
            return Err(format!("{} settings were measured, three are needed", lines.len()));
        };
        let units = |f: &[&str; 9]| [f[4], f[7], f[8]].map(str::to_owned);
        if lines.iter().any(|f| units(f) != units(first)) {
            return Err("its settings differ in units, or in what they are held against".to_owned());
        }
        let settings: Vec<Setting> = lines.iter().map(|f| setting(f)).collect::<Result<_, _>>()?;
        for (k, setting) in settings.iter().enumerate() {
            if settings[..k].iter().any(|before| before.name == setting.name) {
                return Err(format!("setting {:?} stands twice", setting.name));
            }
        }
        let chosen: Vec<&Setting> = settings.iter().filter(|s| s.is_chosen).collect();
        let [chosen] = chosen[..] else {
            return Err(format!("{} of its settings are chosen, not one", chosen.len()));
        };
        // Both were rounded to a double when they were written.
        let off = |s: &&Setting| (s.ratio * chosen.time / s.time - 1.0).abs() > 1e-9;
        if let Some(wrong) = settings.iter().find(off) {
            return Err(format!(
                "setting {:?} has a ratio of {}, which its times have not",
                wrong.name, wrong.ratio
            ));
        }
        let [time_unit, error_unit, against] = units(first);
        Ok(Self {
            dial,
            time_unit,
            error_unit,
            against,
            settings,
        })
    }

    /// The setting that the others are over.
    pub(super) fn chosen(&self) -> Option<&Setting> {
        self.settings.iter().find(|s| s.is_chosen)
    }
}

fn fields(line: &str) -> Result<[&str; 9], String> {
    let fields: Vec<&str> = line.split(',').collect();
    let count = fields.len();
    <[&str; 9]>::try_from(fields).map_err(|_| format!("{count} fields, not 9: {line:?}"))
}

fn setting(fields: &[&str; 9]) -> Result<Setting, String> {
    let name = fields[1];
    let number = |what: &str, text: &str| {
        let found = text.parse::<f64>().ok().filter(|x| x.is_finite() && *x > 0.0);
        found.ok_or_else(|| format!("setting {name:?} has {what} {text:?}, which is no number above zero"))
    };
    Ok(Setting {
        name: name.to_owned(),
        is_chosen: fields[2] == "1",
        time: number("time", fields[3])?,
        ratio: number("ratio", fields[5])?,
        error: number("error", fields[6])?,
    })
}

#[cfg(test)]
mod tests {
    use super::super::dials::DIALS;
    use super::*;

    fn text(rows: &[&str]) -> String {
        let lines = [HEADER].iter().chain(rows).map(|line| format!("{line}\n"));
        lines.collect()
    }

    const GOOD: [&str; 3] = [
        "filter,nearest,0,1e0,ms,5e-1,3e0,HU,truth",
        "filter,linear,1,2e0,ms,1e0,2e0,HU,truth",
        "filter,cubic,0,4e0,ms,2e0,1e0,HU,truth",
    ];

    fn parsed(rows: &[&str]) -> Result<Vec<Measured>, String> {
        Measured::parse(&text(rows), &DIALS[..1])
    }

    #[test]
    fn what_is_whole_is_read() {
        let measured = parsed(&GOOD).unwrap();
        assert_eq!((measured.len(), measured[0].settings.len()), (1, 3));
        assert_eq!(measured[0].chosen().unwrap().name, "linear");
    }

    #[test]
    fn what_is_missing_or_no_number_is_refused_by_name() {
        let changed = |from: &str, to: &str| {
            parsed(&GOOD.map(|row| row.replace(from, to)).each_ref().map(String::as_str)).unwrap_err()
        };
        assert!(parsed(&GOOD[..2]).unwrap_err().contains("2 settings were measured"));
        assert!(parsed(&[]).unwrap_err().contains("dial filter: 0 settings"));
        assert!(changed("3e0", "NaN").contains("has error \"NaN\""));
        assert!(changed("4e0", "inf").contains("time \"inf\""));
        assert!(changed("4e0", "0e0").contains("time \"0e0\""));
        assert!(changed(",3e0", ",").contains("error \"\""));
        assert!(changed("5e-1", "6e-1").contains("ratio of 0.6"));
        assert!(changed("linear,1", "linear,0").contains("0 of its settings are chosen"));
        assert!(changed("cubic", "linear").contains("stands twice"));
        assert!(changed("filter,cubic", "sharpness,cubic").contains("no dial \"sharpness\""));
        assert!(changed("1e0,HU", "1e0,mm").contains("differ in units"));
        assert!(changed("HU,truth", "HU").contains("8 fields"));
        assert!(
            Measured::parse("dial,time\n", &DIALS)
                .unwrap_err()
                .contains("first line")
        );
    }

    #[test]
    fn benchmarks_write_the_columns_that_are_read() {
        assert!(include_str!("../../../benches/shared/trade.rs").contains(&format!("{HEADER:?}")));
    }
}
