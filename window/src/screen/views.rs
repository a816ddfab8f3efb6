//! Which images a person wants to see: all, those before the tip, or those of the whole body.

use scene::Extent;

use crate::model::Cell;

/// Which images are shown. Whatever is not shown still counts: the state above the images is that of all.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub enum Views {
    /// All of the scene.
    #[default]
    All,
    /// Those that are centred on the tip.
    Local,
    /// Those of the whole examination.
    Global,
}

impl Views {
    /// Each, in the order in which they follow one another.
    pub const ALL: [Self; 3] = [Self::All, Self::Local, Self::Global];

    /// The word in the file that keeps it.
    pub const fn word(self) -> &'static str {
        match self {
            Self::All => "all",
            Self::Local => "local",
            Self::Global => "global",
        }
    }

    fn takes(self, cell: &Cell) -> bool {
        match self {
            Self::All => true,
            Self::Local => cell.extent == Extent::Local,
            Self::Global => cell.extent == Extent::Global,
        }
    }

    /// Those of `cells` that are shown: all where none is of this kind.
    pub fn of(self, cells: &[Cell]) -> Vec<&Cell> {
        let some: Vec<&Cell> = cells.iter().filter(|cell| self.takes(cell)).collect();
        if some.is_empty() { cells.iter().collect() } else { some }
    }

    /// What comes next that shows other images than this; `None` where all images are of one kind.
    pub fn next(self, cells: &[Cell]) -> Option<Self> {
        let place = Self::ALL.iter().position(|views| *views == self).unwrap_or(0);
        let others = Self::ALL.iter().cycle().skip(place + 1).take(Self::ALL.len() - 1);
        others.copied().find(|views| views.of(cells) != self.of(cells))
    }
}
