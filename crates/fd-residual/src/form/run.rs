//! Running a given form.

use fd_core::{
    Buffer, Frame, Heap, IoDims, LinMap, Scalar, StateVisitor, Storage,
    stage::{ResidualGenerator, Stage},
};
use fd_model::freeze;

use super::design::{GeneratorDesign, ResidualForm};
use crate::error::DesignError;

/// A residual generator that computes its form literally: `x⁺ = A x + B_u u + B_y y`,
/// `r = C x + D_u u + D_y y`.
///
/// `U` stores the sizes states × inputs × residuals, `Y` states × outputs × residuals.
#[derive(Clone, Debug)]
pub struct FormGenerator<T: Scalar, U: Storage<T> = Heap, Y: Storage<T> = Heap> {
    io: IoDims,
    a: U::Xx,
    bu: U::Xu,
    by: Y::Xu,
    c: U::Yx,
    du: U::Yu,
    dy: Y::Yu,
    x: U::X,
    x_next: U::X,
}

impl ResidualForm {
    /// Moves the form to run time.
    ///
    /// # Errors
    ///
    /// Returns an error when the form is unstable, or when the storage is fixed and has other
    /// sizes.
    pub fn freeze<T: Scalar, U: Storage<T>, Y: Storage<T>>(
        &self,
    ) -> Result<FormGenerator<T, U, Y>, DesignError> {
        crate::simulation::check_stable("a residual generator", self.system())?;
        let (hu, hy) = (self.hu()?, self.hy()?);
        let x = U::X::zeros("generator state", hu.nx())?;
        Ok(FormGenerator {
            io: self.io(),
            a: freeze("generator matrix A", hu.a())?,
            bu: freeze("generator matrix B_u", hu.b())?,
            by: freeze("generator matrix B_y", hy.b())?,
            c: freeze("generator matrix C", hu.c())?,
            du: freeze("generator matrix D_u", hu.d())?,
            dy: freeze("generator matrix D_y", hy.d())?,
            x_next: x.clone(),
            x,
        })
    }
}

impl GeneratorDesign for ResidualForm {
    fn io(&self) -> IoDims {
        ResidualForm::io(self)
    }

    fn residual_len(&self) -> usize {
        ResidualForm::residual_len(self)
    }

    fn form(&self) -> Result<ResidualForm, DesignError> {
        Ok(self.clone())
    }

    fn build(&self) -> Result<Box<dyn ResidualGenerator>, DesignError> {
        Ok(Box::new(self.freeze::<f64, Heap, Heap>()?))
    }
}

impl<T: Scalar, U: Storage<T>, Y: Storage<T>> Stage<T> for FormGenerator<T, U, Y> {
    fn reset(&mut self) {
        self.x.as_mut().fill(T::zero());
    }

    fn visit_state(&mut self, visitor: &mut dyn StateVisitor<T>) {
        visitor.reals("generator state", self.x.as_mut());
    }
}

impl<T: Scalar, U: Storage<T>, Y: Storage<T>> ResidualGenerator<T> for FormGenerator<T, U, Y> {
    fn io(&self) -> IoDims {
        self.io
    }

    fn residual_len(&self) -> usize {
        self.c.dims().rows
    }

    fn step(&mut self, frame: Frame<'_, T>, r: &mut [T]) {
        let x = self.x.as_ref();
        self.c.mul_into(x, r);
        self.du.mul_add_into(frame.u(), r);
        self.dy.mul_add_into(frame.y(), r);

        let x_next = self.x_next.as_mut();
        self.a.mul_into(x, x_next);
        self.bu.mul_add_into(frame.u(), x_next);
        self.by.mul_add_into(frame.y(), x_next);
        std::mem::swap(&mut self.x, &mut self.x_next);
    }
}
