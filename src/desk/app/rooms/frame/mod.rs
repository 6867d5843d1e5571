//! What surrounds the views: bars, workspaces and notices.

mod control;
pub(crate) mod ui;

use std::path::Path;
use std::time::Instant;

use crate::app::model::Command;
use crate::app::model::command::WindowCommand;
use crate::app::model::notice::{Notice, NoticeLink};
use crate::app::model::purpose::ShareCommand;
use crate::app::model::state::State;
use crate::app::model::window::{HelpPage, NoticeKind, and_others};
use overlook_engine::capture::NO_CAPTURE;
use overlook_engine::error::Error;

impl State {
    /// Adds a message.
    pub(crate) fn notify(&mut self, kind: NoticeKind, title: impl Into<String>, text: impl Into<String>) {
        self.add_notice(kind, title.into(), text.into(), false, None);
    }

    /// Adds a message that a file was written.
    pub(crate) fn notify_of_file(&mut self, title: impl Into<String>, text: impl Into<String>, path: &Path) {
        let link = ("Show in folder", Command::Share(ShareCommand::ShowInFolder(path.to_path_buf())));
        self.add_notice(NoticeKind::Done, title.into(), text.into(), false, Some(link));
    }

    /// Adds a warning about what is open.
    pub(crate) fn warn_of_scene(&mut self, title: impl Into<String>, text: impl Into<String>) {
        self.add_notice(NoticeKind::Warning, title.into(), text.into(), true, None);
    }

    /// Adds a message about what is open that leads somewhere.
    pub(crate) fn notify_with_link(&mut self, kind: NoticeKind, title: &str, text: String, link: NoticeLink) {
        self.add_notice(kind, title.to_owned(), text, true, Some(link));
    }

    /// Adds the message that something failed; of a folder that holds no capture in short, with what opens.
    pub(crate) fn notify_of_failure(&mut self, title: &str, error: &Error) {
        let (text, link) = match error {
            Error::Invalid { place, what } if what.starts_with(NO_CAPTURE) => {
                let link = ("What opens?", Command::Window(WindowCommand::Help(Some(HelpPage::Sources))));
                (format!("No capture in {place}."), Some(link))
            }
            error => (error.to_string(), None),
        };
        self.add_notice(NoticeKind::Error, title.to_owned(), text, false, link);
    }

    /// Adds a message, perhaps one that ends with what is open.
    fn add_notice(
        &mut self,
        kind: NoticeKind,
        title: String,
        text: String,
        ends_with_scene: bool,
        link: Option<NoticeLink>,
    ) {
        self.inspector.log(kind, format!("{title}: {text}"));
        self.notices.retain(|notice| notice.title != title || notice.text != text);
        let id = self.notices.iter().map(|notice| notice.id).max().unwrap_or(0) + 1;
        let scene = self.doc.scene.as_ref().filter(|_| ends_with_scene).map(|scene| scene.id);
        self.notices.push(Notice { id, kind, title, text, since: Instant::now(), scene, link });
    }

    /// Reports once the parts of the open store that could not be read: the first line as a message, all lines in the log.
    pub(crate) fn report_damage(&mut self, lines: &[String]) {
        let told = &mut self.doc.reported_damage;
        let new: Vec<&String> = lines.iter().filter(|line| told.insert((*line).clone())).collect();
        let Some((first, others)) = new.split_first() else { return };
        for line in others {
            self.inspector.log(NoticeKind::Warning, (*line).clone());
        }
        self.warn_of_scene("The store is damaged", and_others(first, others.len()));
    }
}
