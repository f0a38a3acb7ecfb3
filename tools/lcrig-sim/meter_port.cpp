// SPDX-License-Identifier: Apache-2.0
#include "tools/lcrig-sim/meter_port.hpp"

#include <filesystem>
#include <utility>

#include "drivers/fd_transport.hpp"

namespace lcrig::sim {

namespace fs = std::filesystem;

namespace {
constexpr Duration kClientCheck = std::chrono::milliseconds(100);
}

MeterPort::MeterPort(asio::any_io_executor executor, Clock& clock, Tasks& tasks,
                     lcr6100::SimConfig config, lcr6100::Lcr6100Sim::Source source,
                     std::string link)
    : executor_(std::move(executor)),
      clock_(clock),
      tasks_(tasks),
      config_(std::move(config)),
      source_(std::move(source)),
      link_(std::move(link)) {}

MeterPort::~MeterPort() {
  unplug();
}

// Opens a pty. The kernel gives out the lowest free number. To get another one, the old one stays
// open while a second pty is opened.
Result<Pty> MeterPort::open_pty(bool other_port) const {
  auto pty = Pty::open();
  if (!pty || !other_port || pty->path() != last_path_) return pty;
  return Pty::open();
}

Result<> MeterPort::plug(bool other_port) {
  if (pty_) return {};
  if (auto r = keep(open_pty(other_port), pty_); !r) return fail(r.error());
  last_path_ = pty_->path();
  if (auto linked = make_link(); !linked) {
    pty_.reset();
    return linked;
  }
  auto wire =
      std::make_unique<FdTransport>(executor_, clock_, pty_->release_master(), "sim:" + url());
  meter_ = std::make_shared<lcr6100::Lcr6100Sim>(std::move(wire), clock_, config_, source_);
  if (unplugged_) meter_->keep_settings_of(*unplugged_);
  unplugged_.reset();
  meter_->set_hooks(hooks_);
  meter_->faults() = lasting_;
  const auto kept_alive = [kept = meter_] {};
  tasks_.start(meter_->run(), kept_alive);
  tasks_.start(watch_clients(), kept_alive);
  return {};
}

void MeterPort::unplug() {
  if (!pty_) return;
  std::error_code ignored;
  if (!link_.empty()) fs::remove(link_, ignored);
  pty_.reset();
  meter_->close();
  unplugged_ = std::move(meter_);
}

void MeterPort::hook(lcr6100::SimHooks hooks) {
  hooks_ = std::move(hooks);
  if (meter_) meter_->set_hooks(hooks_);
}

void MeterPort::change(const std::function<void(lcr6100::SimFaults&)>& change) {
  change(lasting_);
  if (meter_) change(meter_->faults());
}

void MeterPort::heal() {
  lasting_ = lcr6100::SimFaults();
  if (meter_) meter_->faults() = lasting_;
}

void MeterPort::power_on(const std::string& identity) {
  config_.identity = identity;
  if (const auto& meter = meter_ ? meter_ : unplugged_) meter->power_on(identity);
}

void MeterPort::turn(PanelKey key, const std::string& to) {
  if (const auto& meter = meter_ ? meter_ : unplugged_) meter->turn(key, to);
}

void MeterPort::say_unasked(std::string text) {
  if (!meter_) return;
  tasks_.start(meter_->speak(std::move(text)), [kept = meter_] {});
}

Result<> MeterPort::make_link() const {
  if (link_.empty()) return {};
  std::error_code error;
  if (fs::is_symlink(link_, error)) fs::remove(link_, error);
  fs::create_symlink(pty_->path(), link_, error);
  if (error) return fail(Errc::io, "link {}: {}", link_, error.message());
  return {};
}

Task<> MeterPort::watch_clients() {
  const auto mine = meter_;
  while (meter_ == mine) {
    pty_->forget_dead_client();
    co_await clock_.wait_for(kClientCheck);
  }
}

}  // namespace lcrig::sim
