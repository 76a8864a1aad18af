"""Kills, full disks and other bad luck, by the hundred: `make faults`, and `make faults-short` for every change."""
