//! Candidates that are tried beside causes already accepted.

use fd_effect::{Candidate, Offers, SiteRef, Suspects};
use fd_sim::model::Model;

use super::list::Listed;

/// Suspects beside a cause.
#[derive(Debug)]
pub(super) struct Beside<'a> {
    /// All suspects of the study.
    pub(super) suspects: &'a dyn Suspects,
    /// All causes so far; the model of the last one has all of them.
    pub(super) known: &'a [Listed],
    /// Parameters of the model as it came: an error of a parameter of a cause is no cause.
    pub(super) parameters: &'a [String],
    /// A longer list of causes, refitted together: what is sought anew was fitted there.
    pub(super) fitted: Option<&'a Model>,
}

impl Beside<'_> {
    fn filter(&self, mut offers: Offers) -> Offers {
        offers.retain(|offer| match offer {
            Ok(candidate) => {
                let is_known =
                    self.known.iter().any(|k| k.candidate.identity() == candidate.identity());
                !is_known && self.is_of_the_plant(&candidate.site)
            }
            Err(refusal) => self.is_of_the_plant(&refusal.site),
        });
        offers
    }

    fn is_of_the_plant(&self, site: &SiteRef) -> bool {
        match site {
            SiteRef::Parameter(_, name) => self.parameters.contains(name),
            _ => true,
        }
    }
}

impl Suspects for Beside<'_> {
    fn alone(&self) -> Offers {
        self.filter(match self.known.last() {
            None => self.suspects.alone(),
            Some(last) => self.suspects.beside(&last.candidate),
        })
    }

    fn beside(&self, first: &Candidate) -> Offers {
        self.filter(self.suspects.beside(first))
    }

    fn fitted(&self) -> Option<&Model> {
        self.fitted
    }
}
