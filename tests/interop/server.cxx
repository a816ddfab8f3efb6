// A server that knows nothing of Trocar and reads header version 1 alone: the C++ library OpenIGTLink (Debian: libopenigtlink-dev).
//
//   server push [PORT]     sends TRANSFORMs of two tools to each client, 100 Hz, unasked
//   server images [PORT]   the same, and with each third frame an ultrasound image of the third frame before, with that one's stamp
//   server shifted [PORT]  the same as images, whose stamps are of a clock that is 150 ms behind from frame 400 on, and 600 ms from frame 1100 on
//   server positions [PORT]    sends POSITIONs of both in the place of TRANSFORMs, turned by 120 degrees about (1, -1, 1)
//   server quaternions [PORT]  sends QTDATA of both, turned likewise, unasked
//   server stream [PORT]   sends nothing but TDATA of both, once a client asks for them by STT_TDATA, as often as that says
//
// It prints the port, and a line for each message that it was sent. Frame i has the tool at x = i / 8 mm and the patient at x = -100 mm, both
// with y = (i % 4000) / 1024 mm. Nothing is sent of the tool in every fifth frame, nor in 200 frames of each 500: it is not seen, and
// version 1 has no words for that. An image has 64 x 48 pixels: its first four are the number of its frame, lowest byte first, and
// any other, in column u and row v, is (number + u + 3 v) modulo 256.

#include <poll.h>

#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <string>

#include <igtlImageMessage.h>
#include <igtlMessageHeader.h>
#include <igtlPositionMessage.h>
#include <igtlQuaternionTrackingDataMessage.h>
#include <igtlServerSocket.h>
#include <igtlStatusMessage.h>
#include <igtlTrackingDataMessage.h>
#include <igtlTransformMessage.h>

static const char* TOOL = "StylusToTracker";
static const char* PATIENT = "ReferenceToTracker";

static long long now_ms() {
    timespec time;
    clock_gettime(CLOCK_MONOTONIC, &time);
    return time.tv_sec * 1000LL + time.tv_nsec / 1000000;
}

static bool is_seen(long i) { return i % 5 != 4 && i % 500 < 300; }

static void place(igtl::Matrix4x4& matrix, long i, bool is_tool) {
    igtl::IdentityMatrix(matrix);
    matrix[0][3] = is_tool ? i / 8.0f : -100.0f;
    matrix[1][3] = (i % 4000) / 1024.0f;
    matrix[2][3] = -1500.0f;
}

static bool send_transform(igtl::Socket::Pointer socket, const char* name, long i, bool is_tool, igtl::TimeStamp::Pointer stamp) {
    igtl::Matrix4x4 matrix;
    place(matrix, i, is_tool);
    igtl::TransformMessage::Pointer message = igtl::TransformMessage::New();
    message->SetDeviceName(name);
    message->SetMatrix(matrix);
    message->SetTimeStamp(stamp);
    message->Pack();
    return socket->Send(message->GetPackPointer(), message->GetPackSize()) != 0;
}

static bool send_position(igtl::Socket::Pointer socket, const char* name, long i, bool is_tool, igtl::TimeStamp::Pointer stamp) {
    igtl::Matrix4x4 matrix;
    place(matrix, i, is_tool);
    igtl::PositionMessage::Pointer message = igtl::PositionMessage::New();
    message->SetDeviceName(name);
    message->SetPackType(igtl::PositionMessage::ALL);
    message->SetPosition(matrix[0][3], matrix[1][3], matrix[2][3]);
    message->SetQuaternion(0.5f, -0.5f, 0.5f, 0.5f);
    message->SetTimeStamp(stamp);
    message->Pack();
    return socket->Send(message->GetPackPointer(), message->GetPackSize()) != 0;
}

static void add_quaternion(igtl::QuaternionTrackingDataMessage::Pointer message, const char* name, long i, bool is_tool) {
    igtl::Matrix4x4 matrix;
    place(matrix, i, is_tool);
    igtl::QuaternionTrackingDataElement::Pointer element = igtl::QuaternionTrackingDataElement::New();
    element->SetName(name);
    element->SetType(igtl::QuaternionTrackingDataElement::TYPE_6D);
    element->SetPosition(matrix[0][3], matrix[1][3], matrix[2][3]);
    element->SetQuaternion(0.5f, -0.5f, 0.5f, 0.5f);
    message->AddQuaternionTrackingDataElement(element);
}

static bool send_quaternions(igtl::Socket::Pointer socket, long i, igtl::TimeStamp::Pointer stamp) {
    igtl::QuaternionTrackingDataMessage::Pointer message = igtl::QuaternionTrackingDataMessage::New();
    message->SetDeviceName("Tracker");
    add_quaternion(message, PATIENT, i, false);
    if (is_seen(i)) add_quaternion(message, TOOL, i, true);
    message->SetTimeStamp(stamp);
    message->Pack();
    return socket->Send(message->GetPackPointer(), message->GetPackSize()) != 0;
}

static bool send_image(igtl::Socket::Pointer socket, long i, igtl::TimeStamp::Pointer stamp) {
    const int width = 64, height = 48;
    igtl::ImageMessage::Pointer message = igtl::ImageMessage::New();
    message->SetDimensions(width, height, 1);
    message->SetSpacing(0.1f, 0.2f, 1.0f);
    message->SetScalarType(igtl::ImageMessage::TYPE_UINT8);
    message->SetDeviceName("Image");
    message->SetTimeStamp(stamp);
    message->AllocateScalars();
    unsigned char* grey = static_cast<unsigned char*>(message->GetScalarPointer());
    for (int at = 0; at < width * height; ++at)
        grey[at] = at < 4 ? i >> (8 * at) : i + at % width + 3 * (at / width);
    message->Pack();
    return socket->Send(message->GetPackPointer(), message->GetPackSize()) != 0;
}

static void add(igtl::TrackingDataMessage::Pointer message, const char* name, long i, bool is_tool) {
    igtl::Matrix4x4 matrix;
    place(matrix, i, is_tool);
    igtl::TrackingDataElement::Pointer element = igtl::TrackingDataElement::New();
    element->SetName(name);
    element->SetType(igtl::TrackingDataElement::TYPE_6D);
    element->SetMatrix(matrix);
    message->AddTrackingDataElement(element);
}

static bool send_list(igtl::Socket::Pointer socket, long i, igtl::TimeStamp::Pointer stamp) {
    igtl::TrackingDataMessage::Pointer message = igtl::TrackingDataMessage::New();
    message->SetDeviceName("Tracker");
    add(message, PATIENT, i, false);
    if (is_seen(i)) add(message, TOOL, i, true);
    message->SetTimeStamp(stamp);
    message->Pack();
    return socket->Send(message->GetPackPointer(), message->GetPackSize()) != 0;
}

// What the library's own examples do with a message; false where the connection is over. A header that it cannot read leaves the body in
// the stream, which is taken for headers from then on.
static bool answered(igtl::Socket::Pointer socket, int& every_ms) {
    igtl::MessageHeader::Pointer header = igtl::MessageHeader::New();
    header->InitPack();
    if (socket->Receive(header->GetPackPointer(), header->GetPackSize()) != header->GetPackSize()) return false;
    if (!(header->Unpack() & igtl::MessageHeader::UNPACK_HEADER)) {
        std::printf("BAD HEADER\n");
        std::fflush(stdout);
        return true;
    }
    std::string type = header->GetDeviceType();
    std::printf("%s", type.c_str());
    if (type == "STT_TDATA") {
        igtl::StartTrackingDataMessage::Pointer start = igtl::StartTrackingDataMessage::New();
        start->SetMessageHeader(header);
        start->AllocatePack();
        socket->Receive(start->GetPackBodyPointer(), start->GetPackBodySize());
        if (start->Unpack(1) & igtl::MessageHeader::UNPACK_BODY) {
            every_ms = start->GetResolution();
            std::printf(" %d", every_ms);
            igtl::RTSTrackingDataMessage::Pointer answer = igtl::RTSTrackingDataMessage::New();
            answer->SetStatus(0);
            answer->Pack();
            socket->Send(answer->GetPackPointer(), answer->GetPackSize());
        }
    } else if (type == "GET_STATUS") {
        igtl::StatusMessage::Pointer status = igtl::StatusMessage::New();
        status->SetDeviceName("Server");
        status->SetCode(igtl::StatusMessage::STATUS_OK);
        status->Pack();
        socket->Send(status->GetPackPointer(), status->GetPackSize());
    } else {
        socket->Skip(header->GetBodySizeToRead(), 0);
    }
    std::printf("\n");
    std::fflush(stdout);
    return true;
}

// The descriptor of a socket, which the library keeps for itself.
struct Open : igtl::Socket {
    static int descriptor(igtl::Socket& socket) { return socket.*(&Open::m_SocketDescriptor); }
};

// How far the clock of the images is behind that of the poses.
static long long behind_ns(long i, bool is_shifted) { return !is_shifted || i < 400 ? 0 : i < 1100 ? 150000000LL : 600000000LL; }

// The poses of a frame, as this mode says them.
static bool send_frame(igtl::Socket::Pointer socket, const std::string& mode, long i, igtl::TimeStamp::Pointer stamp) {
    if (mode == "stream") return send_list(socket, i, stamp);
    if (mode == "quaternions") return send_quaternions(socket, i, stamp);
    auto send_one = mode == "positions" ? send_position : send_transform;
    return send_one(socket, PATIENT, i, false, stamp) && (!is_seen(i) || send_one(socket, TOOL, i, true, stamp));
}

static void serve(igtl::Socket::Pointer socket, const std::string& mode) {
    bool is_shifted = mode == "shifted", has_images = is_shifted || mode == "images";
    int every_ms = mode == "stream" ? 0 : 10;
    long long next = now_ms();
    // It goes on counting with each client: a frame is a frame.
    static long i = 0;
    igtl::TimeStamp::Pointer stamp = igtl::TimeStamp::New(), before = igtl::TimeStamp::New();
    for (;;) {
        pollfd one = {Open::descriptor(*socket), POLLIN, 0};
        int rest = every_ms ? static_cast<int>(next - now_ms()) : 100;
        if (poll(&one, 1, rest < 0 ? 0 : rest) > 0 && !answered(socket, every_ms)) return;
        if (!every_ms) {
            next = now_ms();
            continue;
        }
        if (now_ms() < next) continue;
        next += every_ms;
        stamp->GetTime();
        bool sent = send_frame(socket, mode, i, stamp);
        if (has_images && i % 3 == 0) {
            igtlUint32 second, fraction;
            if (before->GetTimeStampUint64() != 0) sent = sent && send_image(socket, i - 3, before);
            stamp->GetTimeStamp(&second, &fraction);
            long long at_ns = second * 1000000000LL + fraction - behind_ns(i, is_shifted);
            before->SetTime(at_ns / 1000000000LL, at_ns % 1000000000LL);
        }
        if (!sent) return;
        ++i;
    }
}

int main(int argc, char** argv) {
    if (argc < 2) return 2;
    std::signal(SIGPIPE, SIG_IGN);
    igtl::ServerSocket::Pointer server = igtl::ServerSocket::New();
    if (server->CreateServer(argc > 2 ? std::atoi(argv[2]) : 0) != 0) return 1;
    std::printf("%d\n", server->GetServerPort());
    std::fflush(stdout);
    for (;;) {
        igtl::ClientSocket::Pointer client = server->WaitForConnection(60000);
        if (client.IsNull()) continue;
        serve(client.GetPointer(), argv[1]);
        client->CloseSocket();
        std::printf("gone\n");
        std::fflush(stdout);
    }
}
