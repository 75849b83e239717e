// The page that a program serves.
import { start } from "./page.js";
import { Server } from "./server.js";

start(new Server());
