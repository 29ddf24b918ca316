//! Designs that end in a part which is a design itself.

/// Implements [`GeneratorDesign`](super::GeneratorDesign) by a field: a form, a bank, a window, an observer.
macro_rules! design_by_part {
    ($design:ty, $part:ident) => {
        impl $crate::form::GeneratorDesign for $design {
            fn io(&self) -> ::fd_core::IoDims {
                $crate::form::GeneratorDesign::io(&self.$part)
            }

            fn residual_len(&self) -> usize {
                $crate::form::GeneratorDesign::residual_len(&self.$part)
            }

            fn form(&self) -> Result<$crate::form::ResidualForm, $crate::error::DesignError> {
                $crate::form::GeneratorDesign::form(&self.$part)
            }

            fn build(
                &self,
            ) -> Result<Box<dyn ::fd_core::stage::ResidualGenerator>, $crate::error::DesignError>
            {
                $crate::form::GeneratorDesign::build(&self.$part)
            }
        }
    };
}

pub(crate) use design_by_part;
