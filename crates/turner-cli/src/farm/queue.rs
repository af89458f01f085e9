//! The queues that jobs are written for: one line and one template each.

use clap::ValueEnum;

/// A queue.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum Queue {
    /// A shell script: one part after another
    Shell,
    /// GNU parallel: on this machine or over ssh
    Parallel,
    /// A Slurm array job
    Slurm,
    /// Open Job Description, for AWS Deadline Cloud and others
    Openjd,
    /// A Kubernetes indexed Job
    Kubernetes,
}

impl Queue {
    /// Its job, with places for what differs.
    pub(super) fn template(self) -> &'static str {
        match self {
            Queue::Shell => include_str!("../../templates/farm/shell.sh"),
            Queue::Parallel => include_str!("../../templates/farm/parallel.sh"),
            Queue::Slurm => include_str!("../../templates/farm/slurm.sh"),
            Queue::Openjd => include_str!("../../templates/farm/openjd.yaml"),
            Queue::Kubernetes => include_str!("../../templates/farm/kubernetes.yaml"),
        }
    }

    /// The command that starts a job in a file.
    pub(super) fn command(self, file: &str) -> String {
        match self {
            Queue::Shell | Queue::Parallel => format!("sh {file}"),
            Queue::Slurm => format!("sbatch {file}"),
            Queue::Openjd => format!("openjd run {file}"),
            Queue::Kubernetes => format!("kubectl apply -f {file}"),
        }
    }
}
