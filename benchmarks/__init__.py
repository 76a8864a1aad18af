"""Times of this project and of others on the same work; `python -m benchmarks` measures, `make bench` does all."""
