// SPDX-License-Identifier: Apache-2.0
// Tells when a sample of the frame was taken, on the run's clock. The time of arrival alone does
// not: samples come in batches, and some come late. The device's own clock runs evenly, but with
// another zero and another rate. The export and the alignment of readings use it.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "storage/sqlite.hpp"

namespace lcrig {

class DeviceClock {
 public:
  // Fits offset and rate in pieces of about ten minutes, and anew where the clock jumped. The
  // fitted line lies below all delays of arrival and as near to them as it can, because a delay is
  // never negative. Only parts of a long run are read.
  static Result<DeviceClock> fit(const Database& db, std::int64_t run);

  // The time of a sample. It is the time of arrival where there is no device time, or where the
  // clock is not credible (it stands still, or its rate is beyond any crystal).
  struct Time {
    std::int64_t t_ns = 0;
    bool of_arrival = true;
    double residual_s = 0;  // of the piece
  };
  Time at(std::int64_t received_ns, std::optional<double> device_time_s) const;

  // One piece of the fit, valid from the arrival of its first sample to that of the next piece.
  struct Piece {
    std::int64_t from_ns = 0;
    bool known = false;  // false: the clock is not credible in this piece
    std::int64_t offset_ns = 0;  // run's clock less device's clock, at from_ns
    double rate = 0;  // at which the offset grows: seconds per second
    double residual_s = 0;  // root mean square distance of the quickest arrivals from the line
  };
  const std::vector<Piece>& pieces() const { return pieces_; }

 private:
  std::vector<Piece> pieces_;
};

}  // namespace lcrig
