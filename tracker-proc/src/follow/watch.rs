//! A file that is looked at once a second by a thread of its own: a network folder that does not answer holds up that thread,
//! and no pose.

use std::fs;
use std::os::unix::fs::MetadataExt;
use std::path::{Path, PathBuf};
use std::sync::mpsc::{Receiver, RecvTimeoutError, Sender, channel};
use std::time::Duration;

use bus::clock;

use super::link_files::name;

/// Files are looked at this often.
const EVERY: Duration = Duration::from_secs(1);
/// The first look is waited for this long, so that a run begins with its constants.
const FIRST: Duration = Duration::from_secs(3);
/// After this long without a look a person is told.
const SILENT: Duration = Duration::from_secs(5);

/// What tells one content of a file from another: when it was written and when it was changed, which nobody can set back, how long it is, and which
/// file it is.
type Mark = ([i64; 4], u64, u64);
/// What a look found, where it is something else than before.
type News<T> = Option<Result<T, String>>;

/// What was read of a file last.
pub(super) struct Watched<T> {
    path: PathBuf,
    news: Receiver<News<T>>,
    held: Result<T, String>,
    /// When the last look was over, on the run's clock; `None`: it was not asked yet.
    looked_ns: Option<i64>,
    silent_ns: i64,
}

impl<T: Send + 'static> Watched<T> {
    /// Watches `path`; `read` makes of it what is handed over, each time it is another file than before.
    pub(super) fn new(path: PathBuf, read: impl Fn() -> Result<T, String> + Send + 'static) -> Self {
        let (sender, news) = channel();
        let watched = path.clone();
        // Not joined: it ends when nobody listens any more, or with the process where a look never ends.
        std::thread::spawn(move || watch(&watched, &read, &sender));
        Self {
            held: Err(format!("{} was not read yet", name(&path))),
            path,
            news,
            looked_ns: None,
            silent_ns: 0,
        }
    }

    /// Waits a moment for the first look.
    pub(super) fn first(&mut self) {
        match self.news.recv_timeout(FIRST) {
            Ok(found) => {
                self.put(found);
            }
            Err(RecvTimeoutError::Timeout | RecvTimeoutError::Disconnected) => {}
        }
    }

    /// Takes what was found since the last call, and tells whether it was something else; never waits.
    pub(super) fn take(&mut self, now_ns: i64) -> bool {
        let mut changed = false;
        let mut looked = false;
        while let Ok(found) = self.news.try_recv() {
            looked = true;
            changed |= self.put(found);
        }
        if looked || self.looked_ns.is_none() {
            self.looked_ns = Some(now_ns);
        }
        self.silent_ns = now_ns - self.looked_ns.unwrap_or(now_ns);
        changed
    }

    fn put(&mut self, found: News<T>) -> bool {
        let Some(held) = found else { return false };
        match &held {
            Ok(_) => bus::stderr_line!("tracker: {} is in use", self.path.display()),
            Err(why) => bus::stderr_line!("tracker: not used: {why} ({})", self.path.display()),
        }
        self.held = held;
        true
    }
}

impl<T> Watched<T> {
    /// What was read last, or why it is not used.
    pub(super) fn held(&self) -> &Result<T, String> {
        &self.held
    }

    /// Says that the file was not looked at for long; `None` where it was.
    pub(super) fn silent(&self) -> Option<String> {
        let silent_s = clock::ms(self.silent_ns) / 1e3;
        (self.silent_ns > clock::ns(SILENT)).then(|| {
            format!(
                "{} cannot be looked at for {silent_s:.0} s: does its folder answer?",
                name(&self.path)
            )
        })
    }
}

/// Looks until nobody listens.
fn watch<T>(path: &Path, read: &impl Fn() -> Result<T, String>, sender: &Sender<News<T>>) {
    let mut last: Option<Option<Mark>> = None;
    loop {
        let mark = fs::metadata(path).ok().map(|m| {
            (
                [m.mtime(), m.mtime_nsec(), m.ctime(), m.ctime_nsec()],
                m.size(),
                m.ino(),
            )
        });
        let other = last != Some(mark);
        last = Some(mark);
        if sender.send(other.then(read)).is_err() {
            return;
        }
        std::thread::sleep(EVERY);
    }
}

#[cfg(test)]
mod tests {
    use std::fs::OpenOptions;
    use std::io::Read;

    use super::*;

    const S: i64 = 1_000_000_000;

    fn pipe(folder: &Path) -> PathBuf {
        let path = folder.join("pipe");
        rustix::fs::mknodat(
            rustix::fs::CWD,
            &path,
            rustix::fs::FileType::Fifo,
            rustix::fs::Mode::RUSR | rustix::fs::Mode::WUSR,
            0,
        )
        .unwrap();
        path
    }

    /// Files were read by the thread that makes poses: a folder that hung stopped them.
    #[test]
    fn a_file_that_hangs_holds_nobody_up_and_is_used_once_it_answers() {
        let folder = tempfile::tempdir().unwrap();
        let path = pipe(folder.path());
        let hanging = path.clone();
        let mut watched = Watched::new(path.clone(), move || {
            // Opening a pipe waits for its writer, as a network folder that is away waits for its server.
            let mut text = String::new();
            fs::File::open(&hanging).unwrap().read_to_string(&mut text).unwrap();
            Ok(text)
        });
        watched.first();
        for second in 0..7 {
            assert!(!watched.take(second * S));
        }
        assert_eq!(watched.held().as_ref().unwrap_err(), "pipe was not read yet");
        let told = watched.silent().unwrap();
        assert!(told.contains("pipe cannot be looked at for 6 s"), "{told}");
        let mut writer = OpenOptions::new().write(true).open(&path).unwrap();
        std::io::Write::write_all(&mut writer, b"content").unwrap();
        drop(writer);
        let found = watched.news.recv_timeout(Duration::from_secs(30)).unwrap();
        assert!(watched.put(found));
        assert_eq!(watched.held().as_deref(), Ok("content"));
    }

    #[test]
    fn a_file_is_read_again_only_where_it_is_another() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("f");
        fs::write(&path, "a").unwrap();
        let reading = path.clone();
        let watched = Watched::new(path.clone(), move || {
            fs::read_to_string(&reading).map_err(|_| "is not there".to_owned())
        });
        let next = || watched.news.recv_timeout(Duration::from_secs(30)).unwrap();
        assert_eq!(next(), Some(Ok("a".to_owned())));
        assert_eq!(next(), None);
        fs::remove_file(&path).unwrap();
        // Looks at what has not changed yet may lie between.
        let changed = std::iter::repeat_with(next).find_map(|found| found);
        assert_eq!(changed, Some(Err("is not there".to_owned())));
        assert_eq!(next(), None);
    }
}
