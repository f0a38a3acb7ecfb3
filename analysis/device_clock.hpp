// SPDX-License-Identifier: Apache-2.0
// Tells when a sample of the frame was taken, on the run's clock. Samples come in batches and some
// come late, so their times of arrival go in steps. The device's own clock does not, but it has
// another zero and another rate. The export and the alignment of readings use it.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "storage/sqlite.hpp"

namespace lcrig {

class DeviceClock {
 public:
  // Offset and rate are fitted in pieces of about ten minutes, and anew where the clock jumped. The
  // fitted line lies below all delays of arrival and as near to them as it can, because a delay is
  // never negative. For a long run only some stretches are read.
  static Result<DeviceClock> fit(const Database& db, std::int64_t run);

  // The time of arrival where there is no device time, or where the clock cannot be believed (it
  // stands, or runs at a rate that no crystal has).
  struct Time {
    std::int64_t t_ns = 0;
    bool of_arrival = true;
    double residual_s = 0;  // of the piece
  };
  Time at(std::int64_t received_ns, std::optional<double> device_time_s) const;

  // From the arrival of its first sample to that of the next piece.
  struct Piece {
    std::int64_t from_ns = 0;
    bool known = false;  // else the clock cannot be believed here
    std::int64_t offset_ns = 0;  // run's clock less device's, at from_ns
    double rate = 0;  // of the offset: seconds per second
    double residual_s = 0;  // root mean square of the quickest arrivals about the line
  };
  const std::vector<Piece>& pieces() const { return pieces_; }

 private:
  std::vector<Piece> pieces_;
};

}  // namespace lcrig
