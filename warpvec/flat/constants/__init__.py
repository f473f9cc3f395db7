"""The tuned numbers of flat art: for each stage one frozen record, each number with its reason."""
