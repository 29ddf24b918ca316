//! Running generators side by side.

use std::{fmt::Debug, marker::PhantomData};

use fd_core::{
    Frame, IoDims, Scalar, Shape, ShapeError, StateVisitor,
    stage::{ResidualGenerator, Stage},
};

/// Members of one type `G` in an array or a `Vec`; mix types with `G = Box<dyn …>`.
#[derive(Clone, Debug)]
pub struct Bank<G, M = Vec<G>> {
    members: M,
    member: PhantomData<G>,
}

impl<G, M: AsRef<[G]> + AsMut<[G]>> Bank<G, M> {
    /// A bank of at least one member.
    ///
    /// # Errors
    ///
    /// Returns an error when the members accept different channels, or there is none.
    ///
    /// # Examples
    ///
    /// ```
    /// use faer::mat;
    /// use fd_core::{Fixed, stage::ResidualGenerator};
    /// use fd_model::{Discrete, SampleTime, StateSpace};
    /// use fd_residual::{bank::Bank, observer::ObserverDesign};
    ///
    /// let domain = Discrete { ts: SampleTime::new(0.1)? };
    /// let lag = StateSpace::new(mat![[0.9]], mat![[1.0]], mat![[1.0]], mat![[0.0]], domain)?;
    /// let slow = ObserverDesign::faster(&lag, 1.5)?.freeze::<f64, Fixed<1, 1, 1>>()?;
    /// let fast = ObserverDesign::faster(&lag, 8.0)?.freeze()?;
    /// let bank = Bank::<_, [_; 2]>::new::<f64>([slow, fast])?;
    /// assert_eq!(ResidualGenerator::<f64>::residual_len(&bank), 2);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn new<T: Scalar>(members: M) -> Result<Self, ShapeError>
    where
        G: ResidualGenerator<T>,
    {
        let all = members.as_ref();
        let shape = |g: &G| Shape::new(g.io().ny, g.io().nu);
        let role = "plant of a bank member";
        let Some(first) = all.first() else {
            let empty = Shape::new(0, 0);
            return Err(ShapeError { role, expected: Shape::new(1, 0), found: empty });
        };
        let expected = shape(first);
        match all.iter().map(shape).find(|&found| found != expected) {
            Some(found) => Err(ShapeError { role, expected, found }),
            None => Ok(Self { members, member: PhantomData }),
        }
    }
}

impl<T, G, M> Stage<T> for Bank<G, M>
where
    T: Scalar,
    G: ResidualGenerator<T>,
    M: AsRef<[G]> + AsMut<[G]> + Debug + Send + Sync,
{
    fn reset(&mut self) {
        self.members.as_mut().iter_mut().for_each(Stage::reset);
    }

    fn visit_state(&mut self, visitor: &mut dyn StateVisitor<T>) {
        for member in self.members.as_mut() {
            member.visit_state(visitor);
        }
    }
}

impl<T, G, M> ResidualGenerator<T> for Bank<G, M>
where
    T: Scalar,
    G: ResidualGenerator<T>,
    M: AsRef<[G]> + AsMut<[G]> + Debug + Send + Sync,
{
    fn io(&self) -> IoDims {
        // The constructor refuses an empty bank.
        self.members.as_ref()[0].io()
    }

    fn residual_len(&self) -> usize {
        self.members.as_ref().iter().map(ResidualGenerator::residual_len).sum()
    }

    fn step(&mut self, frame: Frame<'_, T>, r: &mut [T]) {
        let mut rest = r;
        for member in self.members.as_mut() {
            let (own, others) = rest.split_at_mut(member.residual_len());
            member.step(frame, own);
            rest = others;
        }
    }
}
