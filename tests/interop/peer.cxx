// A client of the server gateway-proc that knows nothing of Trocar: the C++ library OpenIGTLink (Debian: libopenigtlink-dev) reads every
// message and checks its CRC.
//
//   peer HOST PORT listen COUNT [QUERY...]   prints COUNT messages, a line each; queries are sent first
//   peer HOST PORT latency COUNT             prints of COUNT TRANSFORMs how late each is behind its stamp, ns
//   peer HOST PORT anchor                    is itself a server, which packs and sends 512 x 512 x 400 voxels to the first client
//   peer HOST PORT beat HZ                   is itself a server, which sends the first client a TRANSFORM at this pace until it has gone
//   peer HOST PORT volume                    asks for the examination; prints the seconds until it was unpacked, and its voxels' sum
//
// Queries: GET_STATUS GET_TRANS GET_POINT GET_IMAGE GET_CAPABIL STT_TDATA:MS STP_TDATA, each with =DEVICE behind it where one is meant.

#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <ctime>
#include <string>

#include <igtlCapabilityMessage.h>
#include <igtlClientSocket.h>
#include <igtlImageMessage.h>
#include <igtlMessageHeader.h>
#include <igtlPointMessage.h>
#include <igtlServerSocket.h>
#include <igtlStatusMessage.h>
#include <igtlStringMessage.h>
#include <igtlTrackingDataMessage.h>
#include <igtlTransformMessage.h>

static long long now_ns(clockid_t clock) {
    timespec time;
    clock_gettime(clock, &time);
    return time.tv_sec * 1000000000LL + time.tv_nsec;
}

static void print_matrix(igtl::Matrix4x4& m) {
    for (int row = 0; row < 3; ++row)
        for (int column = 0; column < 4; ++column) std::printf(" %.9g", m[row][column]);
}

template <class T>
static typename T::Pointer unpacked(igtl::ClientSocket::Pointer socket, igtl::MessageHeader::Pointer header) {
    typename T::Pointer message = T::New();
    message->SetMessageHeader(header);
    message->AllocatePack();
    if (message->GetPackBodySize() > 0) socket->Receive(message->GetPackBodyPointer(), message->GetPackBodySize());
    if (!(message->Unpack(1) & igtl::MessageHeader::UNPACK_BODY)) {
        std::printf("BAD %s\n", header->GetDeviceType());
        std::exit(2);
    }
    return message;
}

template <class T>
static void send(igtl::ClientSocket::Pointer socket, const std::string& device) {
    typename T::Pointer message = T::New();
    message->SetDeviceName(device.c_str());
    message->Pack();
    socket->Send(message->GetPackPointer(), message->GetPackSize());
}

static void ask(igtl::ClientSocket::Pointer socket, std::string query) {
    std::string device;
    size_t at = query.find('=');
    if (at != std::string::npos) {
        device = query.substr(at + 1);
        query = query.substr(0, at);
    }
    if (query == "GET_STATUS") send<igtl::GetStatusMessage>(socket, device);
    else if (query == "GET_TRANS") send<igtl::GetTransformMessage>(socket, device);
    else if (query == "GET_POINT") send<igtl::GetPointMessage>(socket, device);
    else if (query == "GET_IMAGE") send<igtl::GetImageMessage>(socket, device);
    else if (query == "GET_CAPABIL") send<igtl::GetCapabilityMessage>(socket, device);
    else if (query == "STP_TDATA") send<igtl::StopTrackingDataMessage>(socket, device);
    else if (query.compare(0, 10, "STT_TDATA:") == 0) {
        igtl::StartTrackingDataMessage::Pointer message = igtl::StartTrackingDataMessage::New();
        message->SetDeviceName(device.c_str());
        message->SetResolution(std::atoi(query.c_str() + 10));
        message->SetCoordinateName("");
        message->Pack();
        socket->Send(message->GetPackPointer(), message->GetPackSize());
    } else {
        std::fprintf(stderr, "no such query: %s\n", query.c_str());
        std::exit(2);
    }
}

static bool header_of(igtl::ClientSocket::Pointer socket, igtl::MessageHeader::Pointer header) {
    header->InitPack();
    int got = socket->Receive(header->GetPackPointer(), header->GetPackSize());
    if (got != header->GetPackSize()) return false;
    if (!(header->Unpack() & igtl::MessageHeader::UNPACK_HEADER)) {
        // What a reader of version 1 makes of version 2.
        std::printf("BAD HEADER\n");
        std::exit(2);
    }
    return true;
}

static void show(igtl::ClientSocket::Pointer socket, igtl::MessageHeader::Pointer header) {
    std::string type = header->GetDeviceType();
    unsigned int seconds = 0, nanoseconds = 0;
    igtl::TimeStamp::Pointer stamp = igtl::TimeStamp::New();
    header->GetTimeStamp(stamp);
    stamp->GetTimeStamp(&seconds, &nanoseconds);
    std::printf("%s %s %u.%09u %lld", type.c_str(), header->GetDeviceName(), seconds, nanoseconds, now_ns(CLOCK_REALTIME));
    if (type == "TRANSFORM") {
        igtl::Matrix4x4 matrix;
        unpacked<igtl::TransformMessage>(socket, header)->GetMatrix(matrix);
        print_matrix(matrix);
    } else if (type == "TDATA") {
        igtl::TrackingDataMessage::Pointer message = unpacked<igtl::TrackingDataMessage>(socket, header);
        for (int i = 0; i < message->GetNumberOfTrackingDataElements(); ++i) {
            igtl::TrackingDataElement::Pointer element;
            igtl::Matrix4x4 matrix;
            message->GetTrackingDataElement(i, element);
            element->GetMatrix(matrix);
            std::printf(" %s", element->GetName());
            print_matrix(matrix);
        }
    } else if (type == "RTS_TDATA") {
        std::printf(" %d", unpacked<igtl::RTSTrackingDataMessage>(socket, header)->GetStatus());
    } else if (type == "STATUS") {
        igtl::StatusMessage::Pointer message = unpacked<igtl::StatusMessage>(socket, header);
        std::printf(" %d %s|%s", message->GetCode(), message->GetErrorName(), message->GetStatusString());
    } else if (type == "STRING") {
        std::printf(" %s", unpacked<igtl::StringMessage>(socket, header)->GetString());
    } else if (type == "POINT") {
        igtl::PointMessage::Pointer message = unpacked<igtl::PointMessage>(socket, header);
        for (int i = 0; i < message->GetNumberOfPointElement(); ++i) {
            igtl::PointElement::Pointer element;
            float place[3];
            message->GetPointElement(i, element);
            element->GetPosition(place);
            std::printf(" %s/%s %.9g %.9g %.9g", element->GetName(), element->GetGroupName(), place[0], place[1], place[2]);
        }
    } else if (type == "IMAGE") {
        igtl::ImageMessage::Pointer message = unpacked<igtl::ImageMessage>(socket, header);
        int size[3];
        float spacing[3], origin[3];
        igtl::Matrix4x4 matrix;
        message->GetDimensions(size);
        message->GetSpacing(spacing);
        message->GetOrigin(origin);
        message->GetMatrix(matrix);
        std::printf(" %d %d %d  %.9g %.9g %.9g  %.9g %.9g %.9g ", size[0], size[1], size[2], spacing[0], spacing[1], spacing[2],
                    origin[0], origin[1], origin[2]);
        print_matrix(matrix);
    } else if (type == "CAPABILITY") {
        igtl::CapabilityMessage::Pointer message = unpacked<igtl::CapabilityMessage>(socket, header);
        std::printf(" %d", message->GetNumberOfTypes());
    } else {
        std::printf(" ?");
        socket->Skip(header->GetBodySizeToRead(), 0);
    }
    std::printf("\n");
    std::fflush(stdout);
}

// What the library itself takes for a volume of 209.7 MB: the other side of a comparison.
static int anchor(int port) {
    igtl::ImageMessage::Pointer message = igtl::ImageMessage::New();
    int size[3] = {512, 512, 400}, offset[3] = {0, 0, 0};
    float spacing[3] = {0.7f, 0.7f, 1.0f};
    message->SetDimensions(size);
    message->SetSpacing(spacing);
    message->SetScalarType(igtl::ImageMessage::TYPE_INT16);
    message->SetDeviceName("Volume");
    message->SetSubVolume(size, offset);
    message->AllocateScalars();
    short* voxels = static_cast<short*>(message->GetScalarPointer());
    for (long i = 0; i < 512L * 512 * 400; ++i) voxels[i] = static_cast<short>(i % 4096 - 1024);
    igtl::ServerSocket::Pointer server = igtl::ServerSocket::New();
    if (server->CreateServer(port) != 0) return 1;
    std::printf("listening\n");
    std::fflush(stdout);
    igtl::ClientSocket::Pointer client = server->WaitForConnection(20000);
    if (client.IsNull()) return 1;
    igtl::MessageHeader::Pointer asked = igtl::MessageHeader::New();
    asked->InitPack();
    client->Receive(asked->GetPackPointer(), asked->GetPackSize());
    long long begun = now_ns(CLOCK_MONOTONIC);
    message->Pack();
    long long packed = now_ns(CLOCK_MONOTONIC);
    client->Send(message->GetPackPointer(), message->GetPackSize());
    std::printf("pack %.3f send %.3f s\n", (packed - begun) / 1e9, (now_ns(CLOCK_MONOTONIC) - packed) / 1e9);
    client->CloseSocket();
    return 0;
}

// What the library itself takes for a pose: stamped just before it is packed and sent, as a server of one thread does.
static int beat(int port, long hz) {
    igtl::ServerSocket::Pointer server = igtl::ServerSocket::New();
    if (hz < 1 || server->CreateServer(port) != 0) return 1;
    std::printf("listening\n");
    std::fflush(stdout);
    igtl::ClientSocket::Pointer client = server->WaitForConnection(20000);
    if (client.IsNull()) return 1;
    const timespec pace = {hz == 1 ? 1 : 0, hz == 1 ? 0 : 1000000000L / hz};
    for (long count = 0;; ++count) {
        igtl::Matrix4x4 matrix;
        igtl::IdentityMatrix(matrix);
        matrix[0][3] = static_cast<float>(count % 1000);
        // A message that is used again keeps its first stamp.
        igtl::TransformMessage::Pointer message = igtl::TransformMessage::New();
        message->SetDeviceName("ToolToRas");
        message->SetMatrix(matrix);
        igtl::TimeStamp::Pointer stamp = igtl::TimeStamp::New();
        long long now = now_ns(CLOCK_REALTIME);
        stamp->SetTimeInNanoseconds(now);
        message->SetTimeStamp(stamp);
        message->Pack();
        if (!client->Send(message->GetPackPointer(), message->GetPackSize())) return 0;
        nanosleep(&pace, nullptr);
    }
}

int main(int argc, char** argv) {
    if (argc < 4) return 2;
    if (std::strcmp(argv[3], "beat") == 0) return beat(std::atoi(argv[2]), argc > 4 ? std::atol(argv[4]) : 60);
    if (std::strcmp(argv[3], "anchor") == 0) return anchor(std::atoi(argv[2]));
    igtl::ClientSocket::Pointer socket = igtl::ClientSocket::New();
    if (socket->ConnectToServer(argv[1], std::atoi(argv[2])) != 0) {
        std::fprintf(stderr, "cannot connect\n");
        return 1;
    }
    std::string mode = argv[3];
    int count = argc > 4 ? std::atoi(argv[4]) : 0;
    for (int i = 5; i < argc; ++i) ask(socket, argv[i]);
    igtl::MessageHeader::Pointer header = igtl::MessageHeader::New();
    if (mode == "listen") {
        for (int i = 0; i < count && header_of(socket, header); ++i) show(socket, header);
        return 0;
    }
    if (mode == "latency") {
        while (count > 0 && header_of(socket, header)) {
            if (std::strcmp(header->GetDeviceType(), "TRANSFORM") != 0) {
                socket->Skip(header->GetBodySizeToRead(), 0);
                continue;
            }
            igtl::TransformMessage::Pointer message = unpacked<igtl::TransformMessage>(socket, header);
            unsigned int seconds = 0, nanoseconds = 0;
            igtl::TimeStamp::Pointer stamp = igtl::TimeStamp::New();
            header->GetTimeStamp(stamp);
            stamp->GetTimeStamp(&seconds, &nanoseconds);
            std::printf("%lld\n", now_ns(CLOCK_REALTIME) - (seconds * 1000000000LL + nanoseconds));
            --count;
        }
        return 0;
    }
    if (mode == "volume") {
        long long begun = now_ns(CLOCK_MONOTONIC);
        ask(socket, "GET_IMAGE=Volume");
        while (header_of(socket, header)) {
            if (std::strcmp(header->GetDeviceType(), "IMAGE") != 0) {
                socket->Skip(header->GetBodySizeToRead(), 0);
                continue;
            }
            long long first = now_ns(CLOCK_MONOTONIC);
            igtl::ImageMessage::Pointer message = igtl::ImageMessage::New();
            message->SetMessageHeader(header);
            message->AllocatePack();
            long long room = now_ns(CLOCK_MONOTONIC);
            socket->Receive(message->GetPackBodyPointer(), message->GetPackBodySize());
            long long come = now_ns(CLOCK_MONOTONIC);
            if (!(message->Unpack(1) & igtl::MessageHeader::UNPACK_BODY)) return 2;
            long long all = now_ns(CLOCK_MONOTONIC);
            const short* voxels = static_cast<const short*>(message->GetScalarPointer());
            long long sum = 0, n = message->GetImageSize() / 2;
            for (long long i = 0; i < n; ++i) sum += voxels[i];
            std::printf("first %.3f room %.3f come %.3f unpacked %.3f s, %lld voxels, sum %lld\n", (first - begun) / 1e9,
                        (room - begun) / 1e9, (come - begun) / 1e9, (all - begun) / 1e9, n, sum);
            return 0;
        }
    }
    return 1;
}
