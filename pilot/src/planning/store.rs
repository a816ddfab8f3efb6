//! The file of a plan: read whole, written whole, and never over what somebody else wrote meanwhile.

use std::fs::{self, File};
use std::io;
use std::os::unix::fs::{MetadataExt, PermissionsExt, fchown};
use std::path::{Path, PathBuf};

use bus::clock::date;
use guidance::plan::file::{Changed, FileError, MAX_BYTES, PlanFile};
use guidance::plan::{Plan, PlanError};
use scene::file::{OpenError, Part, PartError, read_text};

/// What the file says wrote it.
const WRITER: &str = concat!("trocar ", env!("CARGO_PKG_VERSION"));

/// Why a plan is not read or not written.
#[derive(Debug, thiserror::Error)]
pub(crate) enum StoreError {
    #[error("plan {path}: {source}")]
    Open { path: PathBuf, source: OpenError },
    #[error("plan {path}: {source}")]
    Content { path: PathBuf, source: Box<FileError> },
    #[error(
        "plan {path}: it was changed by somebody else meanwhile ({found}, and what was changed here rests on {known}). Nothing was \
         written and nothing of theirs is lost; close this and open the plan again"
    )]
    Changed {
        path: PathBuf,
        found: String,
        known: String,
    },
    #[error("plan {path}: somebody else is writing it; try again")]
    Busy { path: PathBuf },
    #[error(
        "plan {path}: {part} lies beside it, through which it is written, and is no plain file of its own name; remove it"
    )]
    Part { path: PathBuf, part: PathBuf },
    #[error("plan {path}: writing it through {path}.part: {source}. What was there before is still there")]
    Write { path: PathBuf, source: io::Error },
    #[error(transparent)]
    Plan(#[from] PlanError),
}

/// A plan's file, and what is known to stand in it.
#[derive(Debug, Clone)]
pub(crate) struct PlanStore {
    path: PathBuf,
    /// What was read or written last; `None`: there is no file yet.
    file: Option<PlanFile>,
    /// Whether what stands in the file was changed by other means, and was taken: its id is then not that of its content.
    changed: Changed,
    /// The file as it was when it was looked at last, and whether what stood there was another plan.
    looked: Option<(Trace, bool)>,
}

/// What changes where a file does: its place on the disk, its size, when it was written and changed otherwise; `None`: there is none.
type Trace = Option<[i64; 6]>;

impl PlanStore {
    /// Reads the plan at `path`, if there is one.
    pub(crate) fn open(given: &Path, changed: Changed) -> Result<Self, StoreError> {
        // Through links: a plan that is reached by two names is one plan.
        let path = fs::canonicalize(given).or_else(|_| std::path::absolute(given));
        let path = path.unwrap_or_else(|_| given.to_owned());
        // What was not changed is taken as it is, also where changes would be: a confirmed plan stays one, and is not written again.
        let (file, changed) = match read(&path, Changed::Refused) {
            Err(StoreError::Content { source, .. }) if matches!(*source, FileError::OtherContent { .. }) => {
                (read(&path, changed)?, changed)
            }
            file => (file?, Changed::Refused),
        };
        Ok(Self {
            path,
            file,
            changed,
            looked: None,
        })
    }

    pub(crate) fn path(&self) -> &Path {
        &self.path
    }

    /// The plan, as it stands in the file.
    pub(crate) fn plan(&self) -> Option<&Plan> {
        self.file.as_ref().map(|file| &file.plan)
    }

    /// The id of the file's content; empty where there is none.
    pub(crate) fn id(&self) -> String {
        self.file.as_ref().map(PlanFile::id).unwrap_or_default()
    }

    /// The same as a number; 0 where there is none.
    pub(crate) fn id_number(&self) -> u64 {
        u64::from_str_radix(&self.id(), 16).unwrap_or(0)
    }

    /// Writes `plan`, unless that is what stands there.
    pub(crate) fn save(&mut self, plan: &Plan) -> Result<(), StoreError> {
        if self.plan() == Some(plan) && self.changed == Changed::Refused {
            return Ok(());
        }
        let now = date::now();
        let file = PlanFile {
            plan: plan.clone(),
            written_by: WRITER.to_owned(),
            made_at: self.file.as_ref().map_or(now.clone(), |file| file.made_at.clone()),
            changed_at: now,
        };
        let part = self.lock()?;
        self.is_as_known()?;
        write(part, &self.path, &file).map_err(|source| StoreError::Write {
            path: self.path.clone(),
            source,
        })?;
        (self.file, self.changed, self.looked) = (Some(file), Changed::Refused, None);
        Ok(())
    }

    /// Whether somebody else has changed the file, removed it or made it unreadable. It is read only where it looks as if it were written.
    pub(crate) fn is_changed_elsewhere(&mut self) -> bool {
        let trace = trace(&self.path);
        if let Some((_, is_other)) = self.looked.filter(|(looked, _)| *looked == trace) {
            return is_other;
        }
        let is_other = self.is_as_known().is_err();
        // Looked at before it was read: what is written meanwhile is read the next time.
        self.looked = Some((trace, is_other));
        is_other
    }

    /// The file beside it into which it is written, locked: whoever else writes this plan waits.
    fn lock(&self) -> Result<Part, StoreError> {
        Part::lock(&self.path, 0o600).map_err(|error| {
            let path = self.path.clone();
            match error {
                PartError::NotPlain { part } => StoreError::Part { path, part },
                PartError::Busy => StoreError::Busy { path },
                PartError::Io(source) => StoreError::Write { path, source },
            }
        })
    }

    /// Refuses to write over what somebody else wrote.
    fn is_as_known(&self) -> Result<(), StoreError> {
        let words = |file: Option<&PlanFile>| file.map_or("no file".to_owned(), |file| format!("id {}", file.id()));
        let found = read(&self.path, self.changed)?;
        if found.as_ref().map(PlanFile::id) == self.file.as_ref().map(PlanFile::id) {
            return Ok(());
        }
        Err(StoreError::Changed {
            path: self.path.clone(),
            found: words(found.as_ref()),
            known: words(self.file.as_ref()),
        })
    }
}

fn trace(path: &Path) -> Trace {
    let about = fs::metadata(path).ok()?;
    Some([
        about.ino() as i64,
        about.size() as i64,
        about.mtime(),
        about.mtime_nsec(),
        about.ctime(),
        about.ctime_nsec(),
    ])
}

fn read(path: &Path, changed: Changed) -> Result<Option<PlanFile>, StoreError> {
    let text = match read_text(path, MAX_BYTES as u64) {
        Ok(text) => text,
        Err(_) if fs::symlink_metadata(path).is_err_and(|error| error.kind() == io::ErrorKind::NotFound) => {
            return Ok(None);
        }
        Err(source) => {
            return Err(StoreError::Open {
                path: path.to_owned(),
                source,
            });
        }
    };
    PlanFile::parse(&text, changed)
        .map(Some)
        .map_err(|source| StoreError::Content {
            path: path.to_owned(),
            source: Box::new(source),
        })
}

/// Whole, with the permissions of the file in whose place it comes. One that is confirmed is written by nobody any more.
fn write(mut part: Part, path: &Path, file: &PlanFile) -> io::Result<()> {
    let mode = match fs::metadata(path) {
        Ok(before) => kept_mode(part.file(), &before),
        Err(_) => 0o600,
    };
    let mode = if file.plan.confirmed.is_some() {
        mode & !0o222
    } else {
        mode | 0o200
    };
    part.file().set_permissions(fs::Permissions::from_mode(mode))?;
    part.write(file.text().as_bytes())?;
    part.rename()
}

/// Gives `part` the owner and the group of the file in whose place it comes, and returns who may do what with it. Where the group cannot
/// be given, what the group might do nobody else's group may.
fn kept_mode(part: &File, before: &fs::Metadata) -> u32 {
    let mode = before.mode() & 0o777;
    let Ok(now) = part.metadata() else { return 0o600 };
    if (now.uid(), now.gid()) == (before.uid(), before.gid()) {
        return mode;
    }
    let is_given = fchown(part, Some(before.uid()), Some(before.gid())).is_ok();
    // The owner is given by root alone; a group by each of its members.
    match is_given || fchown(part, None, Some(before.gid())).is_ok() {
        true => mode,
        false => mode & !0o070,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use geometry::Point;
    use guidance::plan::{Confirmed, Edit, Editor, Target};
    use guidance::workflow::VolumeId;

    fn target(name: &str) -> Edit {
        Edit::Add(Target {
            name: name.to_owned(),
            centre: Point::new(1.0, 2.0, 3.0),
            diameter_mm: 5.0,
            entry: None,
            stop_mm: 0.0,
        })
    }

    fn changed(store: &PlanStore, edit: Edit) -> Plan {
        let plan = store.plan().cloned().unwrap_or_else(|| Plan::new(VolumeId([1; 32])));
        let mut editor = Editor::new(plan);
        editor.edit(edit).unwrap();
        editor.plan().clone()
    }

    #[test]
    fn two_that_write_one_plan_lose_nothing() {
        let tmp = tempfile::tempdir().unwrap();
        let path = tmp.path().join("plan.json");
        let open = || PlanStore::open(&path, Changed::Refused).unwrap();
        let (mut a, mut b) = (open(), open());
        a.save(&changed(&a, target("a"))).unwrap();
        let said = b.save(&changed(&b, target("b"))).unwrap_err().to_string();
        assert!(
            said.contains("changed by somebody else") && said.contains("rests on no file"),
            "{said}"
        );
        assert_eq!(open().plan(), a.plan());
        let mut b = open();
        b.save(&changed(&b, target("b"))).unwrap();
        let said = a.save(&changed(&a, target("c"))).unwrap_err().to_string();
        assert!(said.contains(&format!("id {}", b.id())), "{said}");
        let names: Vec<String> = open().plan().unwrap().targets.iter().map(|t| t.name.clone()).collect();
        assert_eq!(names, ["a", "b"]);
        // One that was removed is not written again unasked.
        fs::remove_file(&path).unwrap();
        let said = b.save(&changed(&b, target("c"))).unwrap_err().to_string();
        assert!(said.contains("(no file"), "{said}");
    }

    #[test]
    fn many_that_write_at_once_each_write_whole_or_say_why_not() {
        let tmp = tempfile::tempdir().unwrap();
        let path = tmp.path().join("plan.json");
        let written = std::thread::scope(|scope| {
            let threads: Vec<_> = (0..8)
                .map(|i| {
                    let path = path.clone();
                    scope.spawn(move || {
                        let mut written = Vec::new();
                        for k in 0..20 {
                            let mut store = PlanStore::open(&path, Changed::Refused).unwrap();
                            let name = format!("{i}-{k}");
                            if store.plan().is_some_and(|plan| plan.targets.len() >= 60) {
                                break;
                            }
                            if store.save(&changed(&store, target(&name))).is_ok() {
                                written.push(name);
                            }
                        }
                        written
                    })
                })
                .collect();
            let all = threads.into_iter().flat_map(|thread| thread.join().unwrap());
            all.collect::<std::collections::BTreeSet<String>>()
        });
        let store = PlanStore::open(&path, Changed::Refused).unwrap();
        let there = store.plan().unwrap().targets.iter().map(|target| target.name.clone());
        assert_eq!(there.collect::<std::collections::BTreeSet<String>>(), written);
        assert!(!written.is_empty());
    }

    #[test]
    fn a_confirmed_plan_is_a_file_that_nobody_writes() {
        let tmp = tempfile::tempdir().unwrap();
        let path = tmp.path().join("plan.json");
        let mut store = PlanStore::open(&path, Changed::Refused).unwrap();
        let mut editor = Editor::new(changed(&store, target("a")));
        store.save(editor.plan()).unwrap();
        assert_eq!(fs::metadata(&path).unwrap().permissions().mode() & 0o777, 0o600);
        let confirmed = Confirmed {
            by: "Dr. A".to_owned(),
            at: date::now(),
        };
        editor.confirm(confirmed).unwrap();
        store.save(editor.plan()).unwrap();
        assert_eq!(fs::metadata(&path).unwrap().permissions().mode() & 0o777, 0o400);
        assert_eq!(
            PlanStore::open(&path, Changed::Refused).unwrap().plan(),
            Some(editor.plan())
        );
    }

    /// A plan that others may read or write was theirs no more after the first change.
    #[test]
    fn a_shared_plan_stays_shared() {
        let tmp = tempfile::tempdir().unwrap();
        let path = tmp.path().join("plan.json");
        let mut store = PlanStore::open(&path, Changed::Refused).unwrap();
        store.save(&changed(&store, target("a"))).unwrap();
        for (given, confirmed) in [(0o664, 0o444), (0o640, 0o440), (0o600, 0o400)] {
            fs::set_permissions(&path, fs::Permissions::from_mode(given)).unwrap();
            let is_root = rustix::process::geteuid().is_root();
            if is_root {
                std::os::unix::fs::chown(&path, Some(1234), Some(4321)).unwrap();
            }
            let before = fs::metadata(&path).unwrap();
            let name = format!("{given:o}");
            store.save(&changed(&store, target(&name))).unwrap();
            let after = fs::metadata(&path).unwrap();
            assert_eq!(
                (after.mode() & 0o777, after.uid(), after.gid()),
                (given, before.uid(), before.gid())
            );
            assert_ne!(after.ino(), before.ino());
            let mut last = PlanStore::open(&path, Changed::Refused).unwrap();
            let mut editor = Editor::new(last.plan().unwrap().clone());
            let (by, at) = ("Dr. A".to_owned(), date::now());
            editor.confirm(Confirmed { by, at }).unwrap();
            let open = last.plan().unwrap().clone();
            last.save(editor.plan()).unwrap();
            assert_eq!(fs::metadata(&path).unwrap().mode() & 0o777, confirmed);
            // And back, so that the next of the list begins where this one did.
            last.save(&open).unwrap();
            store = PlanStore::open(&path, Changed::Refused).unwrap();
        }
    }

    #[test]
    fn what_others_do_to_the_file_is_noticed_and_ones_own_changes_are_not_theirs() {
        let tmp = tempfile::tempdir().unwrap();
        let path = tmp.path().join("plan.json");
        let mut mine = PlanStore::open(&path, Changed::Refused).unwrap();
        assert!(!mine.is_changed_elsewhere());
        mine.save(&changed(&mine, target("a"))).unwrap();
        assert!(!mine.is_changed_elsewhere());
        let text = fs::read_to_string(&path).unwrap();
        let mut theirs = PlanStore::open(&path, Changed::Refused).unwrap();
        theirs.save(&changed(&theirs, target("b"))).unwrap();
        assert!(mine.is_changed_elsewhere() && mine.is_changed_elsewhere() && !theirs.is_changed_elsewhere());
        // The same plan again, by whatever way, is the same.
        fs::write(&path, &text).unwrap();
        assert!(!mine.is_changed_elsewhere());
        fs::write(&path, "{").unwrap();
        assert!(mine.is_changed_elsewhere());
        fs::remove_file(&path).unwrap();
        assert!(mine.is_changed_elsewhere());
    }

    #[test]
    fn a_plan_that_was_changed_by_hand_and_taken_is_mended_by_writing_it() {
        let tmp = tempfile::tempdir().unwrap();
        let path = tmp.path().join("plan.json");
        let mut store = PlanStore::open(&path, Changed::Refused).unwrap();
        store.save(&changed(&store, target("a"))).unwrap();
        let text = fs::read_to_string(&path).unwrap().replace("2.0", "2.5");
        fs::write(&path, text).unwrap();
        assert!(PlanStore::open(&path, Changed::Refused).is_err());
        let mut taken = PlanStore::open(&path, Changed::Taken).unwrap();
        let plan = taken.plan().unwrap().clone();
        taken.save(&plan).unwrap();
        let store = PlanStore::open(&path, Changed::Refused).unwrap();
        assert_eq!(store.plan().unwrap().targets[0].centre, Point::new(1.0, 2.5, 3.0));
        // One that nobody changed is not written again.
        let text = fs::read_to_string(&path)
            .unwrap()
            .replace(&store.file.as_ref().unwrap().changed_at, "long ago");
        let good = PlanFile::parse(&text, Changed::Taken).unwrap().text();
        fs::write(&path, &good).unwrap();
        let mut taken = PlanStore::open(&path, Changed::Taken).unwrap();
        let plan = taken.plan().unwrap().clone();
        taken.save(&plan).unwrap();
        assert_eq!(fs::read_to_string(&path).unwrap(), good);
    }

    #[test]
    fn what_lies_where_it_is_written_through_is_refused_and_links_are_one_plan() {
        let tmp = tempfile::tempdir().unwrap();
        let (path, other) = (tmp.path().join("plan.json"), tmp.path().join("other.json"));
        let mut store = PlanStore::open(&path, Changed::Refused).unwrap();
        store.save(&changed(&store, target("a"))).unwrap();
        fs::write(&other, "theirs").unwrap();
        let part = tmp.path().join("plan.json.part");
        let refused = |store: &mut PlanStore| store.save(&changed(store, target("b"))).unwrap_err().to_string();
        fs::hard_link(&other, &part).unwrap();
        let said = refused(&mut store);
        assert!(said.contains("plan.json.part lies beside it"), "{said}");
        assert_eq!(fs::read_to_string(&other).unwrap(), "theirs");
        fs::remove_file(&part).unwrap();
        std::os::unix::fs::symlink(&other, &part).unwrap();
        assert!(refused(&mut store).contains("plan.json.part"));
        fs::remove_file(&part).unwrap();
        let link = tmp.path().join("link.json");
        std::os::unix::fs::symlink(&path, &link).unwrap();
        let mut linked = PlanStore::open(&link, Changed::Refused).unwrap();
        linked.save(&changed(&linked, target("b"))).unwrap();
        assert!(fs::symlink_metadata(&link).unwrap().is_symlink());
        assert!(refused(&mut store).contains("changed by somebody else"));
    }

    #[test]
    fn what_is_no_plan_is_refused_with_its_path() {
        let tmp = tempfile::tempdir().unwrap();
        let path = tmp.path().join("plan.json");
        let said = |path: &Path| PlanStore::open(path, Changed::Refused).unwrap_err().to_string();
        fs::write(&path, "{\"format\": \"trocar-plan\", \"version\": 7}").unwrap();
        assert!(
            said(&path).contains("plan.json: found format \"trocar-plan\", version 7"),
            "{}",
            said(&path)
        );
        fs::write(&path, [0xff, 0xfe]).unwrap();
        assert!(said(&path).contains("plan.json"));
        assert!(said(tmp.path()).contains(&tmp.path().display().to_string()));
        assert!(said(Path::new("/dev/zero")).contains("/dev/zero"));
        // A link that leads nowhere is no plan that could be begun.
        let link = tmp.path().join("link.json");
        std::os::unix::fs::symlink("nowhere", &link).unwrap();
        assert!(said(&link).contains("link.json"));
        // A folder that is not there is said when the plan is written.
        let mut store = PlanStore::open(&tmp.path().join("no/plan.json"), Changed::Refused).unwrap();
        let said = store.save(&changed(&store, target("a"))).unwrap_err().to_string();
        assert!(said.contains("no/plan.json: writing it"), "{said}");
    }
}
