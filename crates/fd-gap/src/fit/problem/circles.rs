//! Errors of angles that begin anew after a turn.

use fd_model::Circle;

use super::Problem;

impl Problem {
    /// Whether errors of angles go on beyond half a turn from now on: on the circle they are a saw, of which slopes promise
    /// nothing where a wheel has run away by some turns.
    pub(crate) fn go_on(&mut self, goes_on: bool) {
        self.goes_on = goes_on;
    }

    /// Whether some output lives on a circle.
    pub(crate) fn has_circles(&self) -> bool {
        self.plan.logs.iter().flat_map(|log| &log.circles).any(|circle| !circle.is_line())
    }

    /// Errors of an output in sigma, from what is simulated and what was measured.
    pub(super) fn compare_output<'y>(
        &self,
        output: usize,
        circle: Circle,
        pairs: impl Iterator<Item = (&'y f64, &'y f64)>,
        errors: &mut [f64],
    ) {
        let (sigma, mut last) = (self.weights.sigma[output], 0.0);
        for (error, (simulated, measured)) in errors.iter_mut().zip(pairs) {
            let missed = simulated - measured;
            let missed = if self.goes_on {
                circle.go_on(missed, &mut last)
            } else {
                circle.shortest(missed)
            };
            *error = missed / sigma;
        }
    }

    /// Takes residuals `r` from those that were found elsewhere. Where an error passes half a turn its residual jumps, and the
    /// change is what it is without the jump; errors with a colour are too small for that.
    pub(crate) fn less(&self, found: &mut [f64], r: &[f64]) {
        found.iter_mut().zip(r).for_each(|(found, r)| *found -= r);
        for (segment, rows) in self.plan.segments.iter().zip(&self.layout.segments) {
            let (log, length) = (&self.plan.logs[segment.log], segment.to - segment.from);
            let turns = log.circles.iter().enumerate().filter(|(_, circle)| !circle.is_line());
            for (c, circle) in turns.filter(|(c, _)| self.weights.colour[*c].order() == 0) {
                let (sigma, first) = (self.weights.sigma[c], rows.start + c * length);
                for change in &mut found[first..first + length] {
                    *change = circle.shortest(*change * sigma) / sigma;
                }
            }
        }
    }
}
