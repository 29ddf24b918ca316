//! The report as a page.

use super::{GapStudy, tables};
use crate::report::{Page, PictureError};

impl GapStudy {
    /// The report as a page.
    ///
    /// # Errors
    ///
    /// Returns an error when a picture cannot be drawn.
    pub fn page(&self) -> Result<Page, PictureError> {
        let report = &self.report;
        let mut page = Page::new("Simulation and reality", &report.headline);
        for table in [tables::groups(report), tables::causes(report)].into_iter().flatten() {
            page.table(table);
        }
        Ok(page)
    }
}
