-- SPDX-License-Identifier: Apache-2.0
-- What a list of runs shows of each run that ended: the numbers of its rows. The chain itself has
-- hundreds of links a run, of which each lies on another page of the file.
CREATE INDEX chain_at_end ON chain (run_id, seq, run_end, level_seq, event_seq, lcr_reading_seq,
  frame_sample_seq) WHERE run_end = 1;
