//! The selection itself.

use fd_model::Record;

use crate::{
    arx::{ArxModel, ArxOrders, Start, check_records},
    error::IdentError,
    order::{FitOrders, OrderProblem, OrderScore, OrderTable, criteria::Information},
};

/// The orders of eq. (14) from 1 up to `largest`; the paper's bound is 5.
///
/// ```
/// # use fd_ident::order::paper_orders;
/// assert_eq!(paper_orders(5).len(), 5);
/// ```
#[must_use]
pub fn paper_orders(largest: usize) -> Vec<ArxOrders> {
    (1..=largest).map(ArxOrders::paper).collect()
}

/// All orders with `na` and delay from 0 to `largest`, and `nb` from 1 to `largest + 1`, so that
/// those of eq. (14) are among them.
///
/// ```
/// # use fd_ident::order::all_orders;
/// assert_eq!(all_orders(5).len(), 6 * 6 * 6);
/// ```
#[must_use]
pub fn all_orders(largest: usize) -> Vec<ArxOrders> {
    let mut all = Vec::new();
    for na in 0..=largest {
        for nb in 1..=largest + 1 {
            all.extend((0..=largest).map(|delay| ArxOrders::new(na, nb, delay)));
        }
    }
    all
}

/// Fits every candidate to the training records and judges it by all criteria.
///
/// Without held-out records the simulation error is left out. Candidates that cannot be fitted
/// keep their place in the table, with the reason.
///
/// # Errors
///
/// Returns an error when there are no candidates or records, when the records do not fit
/// together, or when the widest candidate has too few rows.
///
/// # Examples
///
/// ```
/// use fd_ident::{least_squares::LeastSquares, order::{Criterion, paper_orders, select_orders}};
/// use fd_model::{Channel, Record, SampleTime};
///
/// let (mut u, mut mu) = (vec![], vec![]);
/// for k in 0..200 {
///     u.push(f64::from(k * k % 17));
///     mu.push(0.5 * mu.last().unwrap_or(&0.0) + 2.0 * u[k as usize]);
/// }
/// let (input, residual) = (Channel::numbered("u", 1), Channel::numbered("mu", 1));
/// let record = Record::new(input, residual, u, mu, SampleTime::new(0.1)?)?;
/// let table = select_orders(&paper_orders(3), &LeastSquares::new(), &[&record], &[])?;
/// assert_eq!(table.choice(Criterion::Bic).map(|best| best.orders.na), Some(1));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn select_orders(
    candidates: &[ArxOrders],
    identifier: &(impl FitOrders + ?Sized),
    training: &[&Record],
    held_out: &[&Record],
) -> Result<OrderTable, IdentError> {
    let problem = OrderProblem::new(candidates, training)?;
    let together: Vec<&Record> = training.iter().chain(held_out).copied().collect();
    let nu = check_records(&together)?.inputs().len();
    // Of equally good candidates the one with the fewest parameters comes first.
    let mut sorted = candidates.to_vec();
    sorted.sort_by_key(|orders| (orders.parameters(nu), orders.lag()));
    let score = |orders| score(orders, identifier, &problem, held_out);
    Ok(OrderTable::new(sorted.into_iter().map(score).collect::<Result<_, _>>()?))
}

fn score(
    orders: ArxOrders,
    identifier: &(impl FitOrders + ?Sized),
    problem: &OrderProblem<'_>,
    held_out: &[&Record],
) -> Result<OrderScore, IdentError> {
    let model = match identifier.fit_orders(orders, problem) {
        Ok(model) => model,
        Err(refusal) => return Ok(OrderScore::refused(orders, refusal)),
    };
    let parameters = orders.parameters(model.nu());
    let mut information = Information::default();
    for channel in 0..model.residual_len() {
        let v = problem.mean_square(channel, &model);
        information.add_channel(v, problem.rows(channel), parameters);
    }
    let stable = model.is_stable()?;
    let held_out = match (held_out.is_empty(), stable) {
        (true, _) => None,
        (false, false) => Some(f64::INFINITY),
        (false, true) => Some(relative_simulation_error(&model, held_out)?),
    };
    Ok(OrderScore::fitted(model, information, stable, held_out))
}

/// Root mean square over all channels and records of the simulation error, each relative to the
/// root mean square of the bias.
fn relative_simulation_error(model: &ArxModel, records: &[&Record]) -> Result<f64, IdentError> {
    let mut sum = 0.0;
    for record in records {
        let rms = model.simulation_rms(record, Start::Estimated)?;
        for (channel, rms) in rms.into_iter().enumerate() {
            let (count, power) = record
                .output(channel)
                .filter(|mu| mu.is_finite())
                .fold((0, 0.0), |(count, power), mu| (count + 1, power + mu * mu));
            let power = power / f64::from(count.max(1));
            sum += if power > 0.0 { rms.powi(2) / power } else { 0.0 };
        }
    }
    Ok((sum / (records.len() * model.residual_len()) as f64).sqrt())
}
