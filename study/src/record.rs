//! The lines of `operations.csv`: one for each target of each operation.

use bus::message::Lost;

use crate::truth::LINKS;

/// The columns.
pub const HEADER: &str = "stratum,number,target,verdict,step,check,bump,right,tre_mm,predicted_mm,nees,miss_mm,time_s,strokes,pictures,lost,lost_why,\
                          registration_mm,registration_rms_mm,bump_mm,reference_mm,reference_rms_mm,frame_mm,frame_rms_mm,marker_mm,\
                          tool_mm,tool_rms_mm,organs_mm,rest_mm,model,model_mm,model_95_mm,model_nees,model_tre_mm,why,hash";
/// The most characters that are told of why.
const MOST_WHY: usize = 1000;
/// The longest line, bytes: one of names, numbers and [`MOST_WHY`] characters is shorter.
pub(crate) const MOST_LINE: usize = 8192;
/// How many there are.
const COLUMNS: usize = 36;

/// How an operation ended at a target.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Ended {
    /// The sight said ON TARGET, and she let go.
    Arrived,
    /// She gave up.
    GivenUp,
    /// A step refused to go on.
    Refused,
}

impl Ended {
    const ALL: [(Self, &'static str); 3] = [
        (Self::Arrived, "arrived"),
        (Self::GivenUp, "given-up"),
        (Self::Refused, "refused"),
    ];

    /// The word in the file.
    pub fn word(self) -> &'static str {
        Self::ALL
            .iter()
            .find(|(ended, _)| *ended == self)
            .map_or("", |(_, word)| word)
    }
}

/// One line. A number that is not known is not a number, and an empty field in the file.
#[derive(Debug, Clone, PartialEq)]
pub struct Row {
    /// The stratum.
    pub stratum: String,
    /// The operation's number in it.
    pub number: u64,
    /// The target.
    pub target: String,
    /// How it ended.
    pub ended: Ended,
    /// The step that refused; empty where none did.
    pub step: String,
    /// What `calib check` said: `pass`, `warn` or `fail`; `not-made` where it could not be made, nothing where it was not asked.
    pub check: String,
    /// `before` or `after` the check, where the marker on the patient was moved on it.
    pub bump: String,
    /// Of a refusal by the check: whether the registration was off by more than its own covariance gives for 95 of 100, or than is allowed.
    pub right: Option<bool>,
    /// The true error of the last pose shown, at the target; of an operation that the check refused, of the pose that would have been.
    pub tre_mm: f64,
    /// The radius that holds 95 of 100 of it, as the sight said.
    pub predicted_mm: f64,
    /// The error normalised by its covariance.
    pub nees: f64,
    /// From the true tip to the true target.
    pub miss_mm: f64,
    /// To the target, s.
    pub time_s: f64,
    /// Strokes of the hand.
    pub strokes: u64,
    /// Pictures looked at, and those without a pose.
    pub pictures: [u64; 2],
    /// Of those without a pose how many for each reason, in the order of [`Lost::ALL`].
    pub reasons: Reasons,
    /// What each link has made of the error, mm, and its own prediction of that, in the order of [`LINKS`].
    pub links: [[f64; 2]; LINKS.len()],
    /// What the links do not explain, mm.
    pub rest_mm: f64,
    /// Where the tube moves organs, how their model ended: `settled`, `not settled`, `catching up`, `refused: why`, `no pose`, or `truth` and one of
    /// these, where nobody knows where the organs truly were.
    pub model: String,
    /// How far the model has the target off its true place, the radius of 95 of 100 that it states, that error normalised, and the true error
    /// of the image that shows the target there, mm.
    pub model_numbers: [f64; 4],
    /// Why it was refused.
    pub why: String,
}

/// Pictures without a pose, by reason in the order of [`Lost::ALL`].
pub type Reasons = [u64; Lost::ALL.len()];

/// Links without a prediction have one column.
const UNSTATED: [usize; 3] = [1, 4, 6];
/// The fields behind `right` that are numbers: before the counts, and behind them.
const BEFORE_COUNTS: usize = 5;
const LINK_NUMBERS: usize = 2 * LINKS.len() - UNSTATED.len();

impl Row {
    /// Whether the true error was within the predicted radius; `None` where either is not known.
    pub fn is_within(&self) -> Option<bool> {
        let known = self.tre_mm.is_finite() && self.predicted_mm.is_finite();
        known.then_some(self.tre_mm <= self.predicted_mm)
    }

    /// The line, with its end.
    pub fn line(&self) -> String {
        let mut fields = vec![
            self.stratum.clone(),
            self.number.to_string(),
            self.target.clone(),
            self.ended.word().to_owned(),
            self.step.clone(),
            self.check.clone(),
            self.bump.clone(),
            self.right
                .map_or("", |right| if right { "yes" } else { "no" })
                .to_owned(),
        ];
        let numbers = [self.tre_mm, self.predicted_mm, self.nees, self.miss_mm, self.time_s];
        fields.extend(numbers.map(number));
        fields.extend([self.strokes, self.pictures[0], self.pictures[1]].map(|count| count.to_string()));
        fields.push(told(&self.reasons));
        for (link, [found, predicted]) in self.links.iter().enumerate() {
            fields.push(number(*found));
            if !UNSTATED.contains(&link) {
                fields.push(number(*predicted));
            }
        }
        fields.push(number(self.rest_mm));
        fields.push(plain(&self.model));
        fields.extend(self.model_numbers.map(number));
        fields.push(plain(&self.why));
        sealed(&fields.join(",")) + "\n"
    }

    /// Reads a line without its end.
    ///
    /// # Errors
    /// What is wrong with it, in words; a line that was changed after it was written among that.
    pub fn read(line: &str) -> Result<Self, String> {
        if let Some((text, written)) = line.rsplit_once(',')
            && written != hash(text)
        {
            return Err(format!(
                "its hash is {}, where {:?} is written: it was changed",
                hash(text),
                start(written)
            ));
        }
        let fields: Vec<&str> = line.split(',').collect();
        let [stratum, ordinal, target, ended, step, check, bump, right, rest @ ..] = &fields[..] else {
            return Err(format!("{} fields", fields.len()));
        };
        if fields.len() != COLUMNS {
            return Err(format!("{} fields, {COLUMNS} are expected", fields.len()));
        }
        let count = |text: &str| text.parse::<u64>().map_err(|error| format!("{text:?}: {error}"));
        let ended = Ended::ALL.iter().find(|(_, word)| word == ended);
        let (first, rest) = rest.split_at(BEFORE_COUNTS);
        let [strokes, pictures, lost, reasons, rest @ ..] = rest else {
            return Err("the counts are missing".to_owned());
        };
        let (of_links, rest) = rest.split_at(LINK_NUMBERS);
        let mut of_links = of_links.iter().map(|text| value(text));
        let mut next = || of_links.next().unwrap_or(Ok(f64::NAN));
        let mut links = [[f64::NAN; 2]; LINKS.len()];
        for (link, [found, predicted]) in links.iter_mut().enumerate() {
            *found = next()?;
            if !UNSTATED.contains(&link) {
                *predicted = next()?;
            }
        }
        let [rest_mm, model, of_model @ .., why, _] = rest else {
            return Err("what the links leave is missing".to_owned());
        };
        let mut model_numbers = [f64::NAN; 4];
        for (number, text) in model_numbers.iter_mut().zip(of_model) {
            *number = value(text)?;
        }
        let mut numbers = [f64::NAN; BEFORE_COUNTS];
        for (number, text) in numbers.iter_mut().zip(first) {
            *number = value(text)?;
        }
        let [tre_mm, predicted_mm, nees, miss_mm, time_s] = numbers;
        let pictures = [count(pictures)?, count(lost)?];
        Ok(Self {
            stratum: (*stratum).to_owned(),
            number: count(ordinal)?,
            target: (*target).to_owned(),
            ended: ended.ok_or("how it ended is not known")?.0,
            step: (*step).to_owned(),
            check: (*check).to_owned(),
            bump: (*bump).to_owned(),
            right: match *right {
                "yes" => Some(true),
                "no" => Some(false),
                _ => None,
            },
            tre_mm,
            predicted_mm,
            nees,
            miss_mm,
            time_s,
            strokes: count(strokes)?,
            reasons: reasons_of(reasons, pictures[1])?,
            pictures,
            links,
            rest_mm: value(rest_mm)?,
            model: (*model).to_owned(),
            model_numbers,
            why: (*why).to_owned(),
        })
    }
}

/// One line, and no field that a reader would have to unquote.
fn plain(words: &str) -> String {
    let words: String = words.chars().take(MOST_WHY).collect();
    words.replace(['\n', '\r', ','], " ").replace('"', "'")
}

/// A reason in one word: the words that the operator would have read.
pub(crate) fn word(lost: Lost) -> String {
    lost.words().to_lowercase().replace(' ', "-")
}

/// Reasons and counts of those that there were: `marker-not-seen=12 too-few-emitters=3`.
fn told(reasons: &Reasons) -> String {
    let some = Lost::ALL.into_iter().zip(reasons).filter(|(_, count)| **count > 0);
    let some: Vec<String> = some.map(|(lost, count)| format!("{}={count}", word(lost))).collect();
    some.join(" ")
}

/// The same back; there are as many of all reasons together as pictures without a pose.
fn reasons_of(text: &str, lost: u64) -> Result<Reasons, String> {
    let mut reasons = Reasons::default();
    for part in text.split(' ').filter(|part| !part.is_empty()) {
        let known = part.split_once('=').and_then(|(name, count)| {
            let at = Lost::ALL.into_iter().position(|lost| word(lost) == name)?;
            Some((at, count.parse::<u64>().ok()?))
        });
        let (at, count) = known.ok_or_else(|| format!("{part:?} is no reason with a count"))?;
        if let Some(reason) = reasons.get_mut(at) {
            *reason = count;
        }
    }
    let all = reasons.iter().fold(0_u64, |all, count| all.saturating_add(*count));
    match all == lost {
        true => Ok(reasons),
        false => Err(format!(
            "reasons for {all} pictures without a pose, of which there are {lost}"
        )),
    }
}

/// The first 8 digits of the hash of what stands before it in the line.
fn hash(text: &str) -> String {
    blake3::hash(text.as_bytes()).to_hex()[..8].to_owned()
}

/// The fields of a line with their hash behind them.
pub(crate) fn sealed(fields: &str) -> String {
    format!("{fields},{}", hash(fields))
}

fn start(text: &str) -> String {
    text.chars().take(16).collect()
}

/// The shortest digits that bring back every bit; nothing for what is no number.
fn number(value: f64) -> String {
    if value.is_finite() {
        value.to_string()
    } else {
        String::new()
    }
}

fn value(text: &str) -> Result<f64, String> {
    match text {
        "" => Ok(f64::NAN),
        _ => text.parse().map_err(|error| format!("{text:?}: {error}")),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_line_is_read_as_it_was_written() {
        let row = Row {
            stratum: "usual".to_owned(),
            number: 7,
            target: "iliac-left".to_owned(),
            ended: Ended::GivenUp,
            step: String::new(),
            check: "warn".to_owned(),
            bump: "after".to_owned(),
            right: Some(false),
            tre_mm: 0.1 + 0.2,
            predicted_mm: 1.0 / 3.0,
            nees: 1e-300,
            miss_mm: 5.0,
            time_s: 60.0,
            strokes: 9,
            pictures: [800, 3],
            reasons: [0, 0, 0, 2, 0, 0, 1, 0, 0, 0, 0, 0, 0],
            links: [
                [1.0, 2.0],
                [3.0, 0.0],
                [4.0, 5.0],
                [6.0, 7.0],
                [8.0, 0.0],
                [9.0, 10.0],
                [11.0, 0.0],
            ],
            rest_mm: 1e-9,
            model: "refused: too deep, it says".to_owned(),
            model_numbers: [0.5, 1.5, f64::NAN, 2.5],
            why: String::new(),
        };
        let line = row.line();
        assert_eq!(HEADER.split(',').count(), COLUMNS);
        let back = Row::read(line.trim_end()).unwrap();
        // Columns that do not exist come back as no number.
        assert!([1, 4, 6].iter().all(|link| back.links[*link][1].is_nan()));
        assert!(
            line.contains(",800,3,too-few-emitters=2 reference-lost=1,1,2,3,4,"),
            "{line}"
        );
        assert_eq!(
            (back.reasons, back.links[6][0], back.rest_mm),
            (row.reasons, 11.0, 1e-9)
        );
        assert_eq!(back.line(), line);
        assert_eq!(
            (back.model.as_str(), back.model_numbers[3]),
            ("refused: too deep  it says", 2.5)
        );
        assert_eq!(
            (back.tre_mm, back.nees, back.links[5]),
            (row.tre_mm, row.nees, row.links[5])
        );
        let fields = line.trim_end().rsplit_once(',').unwrap().0;
        for broken in [
            "",
            "a,b",
            &fields.replace("given-up", "gone"),
            &fields.replace("800", "-1"),
            &fields.replace("too-few-emitters=2", "too-few-emitters=1"),
            &fields.replace("too-few-emitters=2", "bored=2"),
            &fields.replace("too-few-emitters=2", "too-few-emitters"),
            &fields.replace(",3,too", ",4,too"),
        ] {
            assert!(Row::read(&sealed(broken)).is_err(), "{broken}");
        }
        assert!(Row::read(&sealed(fields)).is_ok());
    }

    /// An error that was edited in a folder went into the tables of what went on with it, and one that was emptied was left out of them.
    #[test]
    fn a_line_that_was_changed_is_refused() {
        let line = "usual,7,node,arrived,,pass,,,0.25,1,3,5,60,9,800,0,,1,2,3,4,5,6,7,8,9,1,0,0.1,,,,,,";
        let line = sealed(line);
        assert_eq!(Row::read(&line).unwrap().tre_mm, 0.25);
        for other in ["0.26", ""] {
            let why = Row::read(&line.replace(",0.25,", &format!(",{other},"))).unwrap_err();
            assert!(why.contains("it was changed"), "{why}");
        }
    }
}
