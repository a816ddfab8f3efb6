//! A file's index, held against what was read of the file.

use std::path::Path;

use mcap::Summary;

use super::{Verified, lists};
use crate::read::damage::OpenError;
use crate::read::seek;

impl Verified {
    fn hold(&mut self, what: &str, stated: u64, found: u64) {
        if stated != found {
            self.find(format!("the index states {stated} {what}, and there are {found}"));
        }
    }

    /// Holds the index against what was read.
    pub(super) fn hold_index(&mut self, path: &Path) -> Result<(), OpenError> {
        let is_ours = self.is_ours;
        let summary = match seek::stated(path)? {
            seek::Stated::Index(summary) => summary,
            seek::Stated::Unnamed(summary) if !is_ours => {
                self.left_out
                    .push("its index repeats channels without their schemas".to_owned());
                summary
            }
            seek::Stated::Unnamed(_) => {
                self.find(
                    "the index has channels without their schemas, and Trocar's recorder repeats these".to_owned(),
                );
                return Ok(());
            }
            seek::Stated::Nothing if is_ours => {
                self.find("the file has no index, and Trocar's recorder writes one".to_owned());
                return Ok(());
            }
            seek::Stated::Nothing => {
                self.left_out.push("it has no index".to_owned());
                return Ok(());
            }
            seek::Stated::Unreadable(why) => {
                self.find(format!("the file has no index that can be read: {why}"));
                return Ok(());
            }
        };
        self.index(&summary, is_ours);
        let seek::Differences { found, left_out } = seek::differences(path, &summary, is_ours)?;
        found.into_iter().for_each(|words| self.find(words));
        self.left_out.extend(left_out);
        lists::hold(path, &summary, is_ours, &mut |words| self.find(words))
    }

    fn index(&mut self, summary: &Summary, is_ours: bool) {
        let Some(stats) = &summary.stats else {
            match is_ours {
                true => self.find("the index counts nothing, and Trocar's recorder counts".to_owned()),
                false => self.left_out.push("its index counts nothing".to_owned()),
            }
            return;
        };
        self.hold("messages", stats.message_count, self.messages);
        self.hold("attachments", stats.attachment_count.into(), self.attachments);
        for (channel, (topic, found)) in std::mem::take(&mut self.counts) {
            let stated = stats.channel_message_counts.get(&channel).copied().unwrap_or(0);
            self.hold(&format!("messages of {topic}"), stated, found);
        }
    }
}
