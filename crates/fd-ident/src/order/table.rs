//! The outcome of an order selection.

use std::fmt;

use crate::{
    arx::{ArxModel, ArxOrders},
    error::IdentError,
    order::criteria::{Criterion, Information},
};

/// One candidate.
#[derive(Clone, Debug, PartialEq)]
pub struct OrderScore {
    /// Its orders.
    pub orders: ArxOrders,
    /// The fitted model, or why there is none.
    pub model: Result<ArxModel, IdentError>,
    /// Whether its poles are inside the unit circle.
    pub stable: bool,
    /// Simulation error on held-out records relative to the bias; infinite when not stable.
    pub held_out: Option<f64>,
    information: Option<Information>,
}

impl OrderScore {
    pub(super) fn refused(orders: ArxOrders, refusal: IdentError) -> Self {
        Self { orders, model: Err(refusal), stable: false, held_out: None, information: None }
    }

    pub(super) fn fitted(
        model: ArxModel,
        information: Information,
        stable: bool,
        held_out: Option<f64>,
    ) -> Self {
        let orders = model.orders();
        Self { orders, model: Ok(model), stable, held_out, information: Some(information) }
    }

    /// Value of a criterion, when it could be computed.
    #[must_use]
    pub fn value(&self, criterion: Criterion) -> Option<f64> {
        let information = self.information?;
        match criterion {
            Criterion::Aic => Some(information.aic),
            Criterion::Aicc => Some(information.aicc),
            Criterion::Bic => Some(information.bic),
            Criterion::Fpe => Some(information.fpe),
            Criterion::HeldOut => self.held_out,
        }
    }
}

/// All candidates, those with the fewest parameters first.
#[derive(Clone, Debug, PartialEq)]
pub struct OrderTable {
    scores: Vec<OrderScore>,
}

/// What the criteria choose, and how much it matters.
#[derive(Clone, Debug, PartialEq)]
pub struct Verdict {
    /// The choice of each criterion that could be computed.
    pub choices: Vec<(Criterion, ArxOrders)>,
    /// Largest distance between the frequency responses of two chosen models, see
    /// [`ArxModel::response_distance`].
    pub response_distance: f64,
}

impl OrderTable {
    pub(super) fn new(scores: Vec<OrderScore>) -> Self {
        Self { scores }
    }

    /// All candidates.
    #[must_use]
    pub fn scores(&self) -> &[OrderScore] {
        &self.scores
    }

    /// The best candidate by one criterion; of equally good ones that with the fewest parameters.
    #[must_use]
    pub fn choice(&self, criterion: Criterion) -> Option<&OrderScore> {
        let valued = self.scores.iter().filter_map(|score| Some((score, score.value(criterion)?)));
        // `min_by` keeps the first of equals.
        valued.min_by(|(_, a), (_, b)| a.total_cmp(b)).map(|(score, _)| score)
    }

    /// What the criteria choose and whether the choices differ in response.
    #[must_use]
    pub fn verdict(&self) -> Verdict {
        let chosen: Vec<(Criterion, &OrderScore)> = Criterion::ALL
            .into_iter()
            .filter_map(|criterion| Some((criterion, self.choice(criterion)?)))
            .collect();
        let models: Vec<&ArxModel> =
            chosen.iter().filter_map(|(_, score)| score.model.as_ref().ok()).collect();
        let mut response_distance = 0.0_f64;
        for one in &models {
            for other in &models {
                response_distance = response_distance.max(one.response_distance(other));
            }
        }
        let choices =
            chosen.into_iter().map(|(criterion, score)| (criterion, score.orders)).collect();
        Verdict { choices, response_distance }
    }
}

impl Verdict {
    /// Whether two criteria choose different orders.
    #[must_use]
    pub fn disagrees(&self) -> bool {
        self.choices.windows(2).any(|pair| pair[0].1 != pair[1].1)
    }
}

/// One sentence for a report.
impl fmt::Display for Verdict {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Some((_, first)) = self.choices.first() else {
            return f.write_str("no candidate could be fitted");
        };
        if !self.disagrees() {
            return write!(f, "all criteria choose {first}");
        }
        f.write_str("the criteria disagree: ")?;
        for (i, (criterion, orders)) in self.choices.iter().enumerate() {
            write!(f, "{}{criterion} chooses {orders}", if i == 0 { "" } else { ", " })?;
        }
        let percent = 100.0 * self.response_distance;
        write!(f, "; the frequency responses of these models differ by at most {percent:.2} %")
    }
}
