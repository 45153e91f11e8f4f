#!/bin/sh
# What became of a job, by squeue alone: clusters without an accounting database have no sacct.
if ! state=$(squeue --noheader --states=all --jobs="$1" --format=%T 2>&1); then
  # The controller has forgotten the job, or does not answer just now.
  case $state in *"Invalid job id"*) echo failed ;; *) echo running ;; esac
  exit 0
fi
case $state in
  COMPLETED) echo success ;;
  PENDING | RUNNING | COMPLETING | CONFIGURING | REQUEUED | RESIZING | STAGE_OUT | SIGNALING | STOPPED | SUSPENDED) echo running ;;
  *) echo failed ;;
esac
