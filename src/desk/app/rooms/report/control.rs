//! Copies tables.

use super::model::{Table, TableForm, table_text};
use crate::app::control::overlook_app::OverlookApp;
use crate::app::rooms::frame::model::NoticeKind;

impl OverlookApp {
    /// Copies a table as text.
    pub(crate) fn copy_table(&mut self, table: Table, form: TableForm) {
        let Some(text) = table_text(table, form, &self.state) else {
            let text = format!("There is no {} yet.", table.name());
            return self.state.warn_of_scene("Nothing to copy", text);
        };
        self.ctx.copy_text(text);
        let text = format!("The {} is on the clipboard as {}.", table.name(), form.name());
        self.state.notify(NoticeKind::Done, "Copied", text);
    }
}
