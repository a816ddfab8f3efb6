//! Why no grid was found, with the evidence there was.

/// Why no grid was found.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum GridRefused {
    /// There is no such grid.
    #[error("a grid of {cols} columns and {rows} rows: both must be from 3 to 200")]
    BadSize {
        /// Columns asked for.
        cols: usize,
        /// Rows asked for.
        rows: usize,
    },
    /// The distance of discs is no length.
    #[error("a pitch of {pitch_mm} mm is not a finite length above 0")]
    BadPitch {
        /// The pitch asked for, mm.
        pitch_mm: f64,
    },
    /// A mark lies outside the grid.
    #[error("a mark at column {col}, row {row}: the grid has {cols} columns and {rows} rows, counted from 0")]
    BadMark {
        /// Its column.
        col: usize,
        /// Its row.
        row: usize,
        /// Columns of the grid.
        cols: usize,
        /// Rows of the grid.
        rows: usize,
    },
    /// The image cannot hold the grid.
    #[error(
        "an image of {width} x {height} pixels cannot hold {cols} x {rows} discs, for which {needed} pixels a side are needed"
    )]
    TooSmall {
        /// Pixels in a row.
        width: usize,
        /// Rows of pixels.
        height: usize,
        /// Columns of the grid.
        cols: usize,
        /// Rows of the grid.
        rows: usize,
        /// The least side, pixels.
        needed: usize,
    },
    /// Nothing in the image looks like a disc, or hardly anything.
    #[error(
        "no grid found: {candidates} candidates for discs, of which none stand in a lattice (a grid of {discs} discs was looked for)"
    )]
    NoLattice {
        /// Candidates found.
        candidates: usize,
        /// Discs of the grid.
        discs: usize,
    },
    /// What was found is not of the size that was looked for.
    #[error("no grid found: the largest lattice among {candidates} candidates has {found} discs in {seen_cols} columns and {seen_rows} rows; {cols} columns and {rows} rows were looked for. {}", advice([*.seen_cols, *.seen_rows], [*.cols, *.rows]))]
    WrongSize {
        /// Candidates found.
        candidates: usize,
        /// Discs of the lattice.
        found: usize,
        /// Columns in which enough discs were seen.
        seen_cols: usize,
        /// Rows in which enough discs were seen.
        seen_rows: usize,
        /// Columns of the grid.
        cols: usize,
        /// Rows of the grid.
        rows: usize,
    },
    /// The large discs seen do not tell which part of the grid is seen, or which way round.
    #[error("no grid found: {found} discs stand in a lattice, {large} of them large, but {}", undecided(*.ways, *.marks))]
    Undecided {
        /// Discs of the lattice.
        found: usize,
        /// Large ones among them.
        large: usize,
        /// Large discs that the grid is said to have.
        marks: usize,
        /// Ways of counting columns and rows that agree with what is seen, other than by the grid's own symmetry.
        ways: usize,
    },
    /// Too few discs are where the lattice says.
    #[error(
        "no grid found: of the {discs} discs only {found} were seen where the lattice says; at least {needed} are needed"
    )]
    TooFew {
        /// Discs seen.
        found: usize,
        /// Discs of the grid.
        discs: usize,
        /// The least number.
        needed: usize,
    },
}

fn advice(seen: [usize; 2], asked: [usize; 2]) -> &'static str {
    if seen.iter().zip(asked).all(|(s, a)| *s <= a) {
        "Part of the grid may be hidden or out of the image: rows and columns cannot be told then"
    } else {
        "Check the numbers of columns and rows"
    }
}

fn undecided(ways: usize, marks: usize) -> String {
    if ways == 0 {
        return format!(
            "no way of counting columns and rows puts large discs only where the {marks} of the description are. Check \
             the places of the large discs"
        );
    }
    format!(
        "{ways} ways of counting columns and rows agree with them. More of the grid or more of its {marks} large discs \
         must be seen"
    )
}

impl GridRefused {
    /// Discs that support the refusal: the best partial evidence.
    pub fn evidence(&self) -> usize {
        match self {
            Self::WrongSize { found, .. } | Self::TooFew { found, .. } | Self::Undecided { found, .. } => *found,
            _ => 0,
        }
    }
}
