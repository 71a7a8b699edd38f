// SPDX-License-Identifier: MIT
// A CAN interface of Linux, through a raw socket.
// Source: Linux, Documentation/networking/can.rst, chapters 4.1 "RAW protocol sockets" and 6.
#pragma once

#include <string>

#include "linux/can_bus.hpp"
#include "linux/file_descriptor.hpp"

struct can_frame;

namespace flotilla::target {

/// Other programs of this machine see the frames that it sends (candump works); it does not itself.
///
/// After a bus-off nothing is sent before the kernel has no frame of ours any more, so that no fresh
/// command stands behind old ones. The socket stays: the kernel keeps the frames of a closed socket
/// all the same, and would deliver them to a new one as another node's.
class SocketCanBus final : public CanBus {
 public:
  /// Throws std::system_error where there is no AF_CAN or the interface is of another kind.
  SocketCanBus(std::string interface, std::uint8_t node);

  void send(std::span<const link::CanFrame> frames) override;
  bool receive(link::CanFrame& frame) override;
  int descriptor() const override { return socket_.get(); }
  void maintain() override;
  bool usable() const override;

 private:
  /// Recovery is believed at the next maintain(). What a controller had received before its bus-off
  /// can come after the news of it, so a frame is a sign of life only from the next maintain() on.
  enum class Controller { kOn, kOff, kStillOff, kRecovered };

  int open();  ///< 0 or errno
  void close();
  bool running(bool before);
  bool write(const link::CanFrame& frame);
  bool flushed();
  void on_error_frame(const ::can_frame& frame);
  void on_failure(int error);

  std::string interface_;
  std::uint8_t node_;
  FileDescriptor socket_;
  bool running_ = false;   ///< the interface is up and its controller takes part
  bool flushing_ = false;  ///< frames from before a bus-off may still wait in the kernel
  Controller controller_ = Controller::kOn;
};

}  // namespace flotilla::target
