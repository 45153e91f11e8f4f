//! Which way a model is stepped.

/// What `$body` makes of a model with its parameters as `$step`, a [`Step`]: compiled for its structure where this is known,
/// otherwise of the first of `$shape` that it has.
#[macro_export]
macro_rules! stepping {
    ($model:expr, $parameters:expr, |mut $step:ident| $body:expr) => {
        $crate::stepping!($model, $parameters, [], |mut $step| $body)
    };
    ($model:expr, $parameters:expr, [$($shape:ty),*], |mut $step:ident| $body:expr) => {
        match $model.structure() {
            Some(structure) => {
                let mut $step = $crate::Built::new(structure, $parameters);
                $body
            }
            None => {
                let mut $step = $crate::Compiled::new($model, $parameters);
                $(if let Some(mut $step) = <$shape>::new(&$step) { $body } else)* { $body }
            }
        }
    };
}

/// [`stepping!`] of what goes through the samples of many runs: compiled for models of common shapes, too.
#[macro_export]
macro_rules! advancing {
    ($model:expr, $parameters:expr, |mut $step:ident| $body:expr) => {
        $crate::stepping!(
            $model,
            $parameters,
            [$crate::Shaped<_, 1, 2, 1>, $crate::Shaped<_, 1, 3, 1>, $crate::Shaped<_, 1, 5, 1>],
            |mut $step| $body
        )
    };
}
