"""What all of nvcore shares: errors, findings, words, records, outputs."""
